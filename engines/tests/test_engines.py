"""Engines that are installed, on cases whose figures are known."""

import unittest
from concurrent.futures import ThreadPoolExecutor

from support import need, skip

from stiction_engines import adapters, case, measure


def errors(engine, setting, step, name):
    """Errors of a run by measure."""
    (known,) = [known for known in case.read_all([name]) if known.name == name]
    settings = next(s for s in engine.settings() if s.name == setting)
    return {m: error for m, (_, error) in measure.errors(known, engine.record(known, settings, step)).items()}


class Mujoco(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        need("mujoco", "tests of MuJoCo")
        cls.engine = adapters.load("mujoco")

    def test_pyramid_slides_too_far_along_the_diagonal(self):
        # The pyramid inside of the cone has 1 / sqrt(2) of the friction at 45 degrees: 41 % more distance.
        # Measured: 41.2 % at 1 ms. Along an edge of the pyramid only the integrator errs, by -0.2 %.
        truth = 2.0**2 / (2 * 0.5 * 9.81)
        diagonal = errors(self.engine, "default", 1e-3, "slide-45")["stop_distance"] / truth
        self.assertGreater(diagonal, 0.35)
        self.assertLess(diagonal, 0.50)
        self.assertLess(abs(errors(self.engine, "default", 1e-3, "slide-0")["stop_distance"] / truth), 0.005)

    def test_elliptic_cone_does_not(self):
        # Measured: -0.93 mm at 1 ms, half a step of 2 m/s.
        self.assertLess(abs(errors(self.engine, "accurate", 1e-3, "slide-45")["stop_distance"]), 2e-3)

    def test_soft_friction_creeps(self):
        # Friction is viscous at rest. Measured: 3.9e-3 m/s with the defaults, 3.1e-6 m/s with impratio 100.
        default = errors(self.engine, "default", 1e-3, "slope-holds-0")["creep"]
        self.assertGreater(default, 1e-3)
        self.assertLess(default, 1e-2)
        accurate = errors(self.engine, "accurate", 1e-3, "slope-holds-0")["creep"]
        self.assertGreater(accurate, 1e-6)
        self.assertLess(accurate, 1e-5)


class Stiction(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        try:
            cls.engine = adapters.load("stiction")
        except adapters.NotInstalled as error:
            skip(f"tests of stiction: {error}")

    def test_closed_forms(self):
        # All but the robots, whose truths are runs of this engine. The greatest error, 7.5e-8 s of
        # breakaway-0, is that of the measure: it interpolates the instant of break-away linearly between the
        # rows of the log, which has 10 kHz. Errors other than those of break-away are below 1e-8.
        names = [known.name for known in case.read_all() if known.family != "robots"]
        with ThreadPoolExecutor(2) as pool:
            found = dict(zip(names, pool.map(lambda name: errors(self.engine, "exact", 1e-8, name), names)))
        for name, by_measure in found.items():
            for entry, error in by_measure.items():
                with self.subTest(case=name, measure=entry):
                    self.assertLess(abs(error), 1e-7)


if __name__ == "__main__":
    unittest.main()
