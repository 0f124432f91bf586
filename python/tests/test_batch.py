"""Batches of simulations: the bits of single ones, arrays, ends."""

import unittest

from support import SCENARIOS, block, counting, door, hoap2, numpy, stiction

FIELDS = ("base_position", "base_orientation", "base_linear_velocity", "base_angular_velocity", "q", "qd")


def pushed(strength):
    """HOAP-2 that is pushed forward, N."""
    push = {"type": "push", "link": "torso", "force": [strength, 0, 0], "start": 0.05, "duration": 0.1}
    return stiction.Simulation(hoap2(force=[push]))


class Bits(unittest.TestCase):
    def test_commanded_robots(self):
        strengths = [0.0, 5.0, 10.0, 15.0, 20.0]
        batch = stiction.Batch([pushed(strength) for strength in strengths], jobs=2)
        singles = [pushed(strength) for strength in strengths]
        self.assertEqual(len(batch), 5)
        home = singles[0].state.q
        numpy.testing.assert_array_equal(batch.position, numpy.tile(home, (5, 1)))
        arrays = {name: getattr(batch, name) for name in FIELDS}
        for k in range(40):
            target = home + 0.05 * numpy.sin(0.1 * k + numpy.arange(len(home)))
            batch.position[:] = target
            batch.velocity[2] = 0.1
            batch.step(5)
            for i, single in enumerate(singles):
                velocity = numpy.full(len(home), 0.1 if i == 2 else 0.0)
                single.command(position=target, velocity=velocity, effort=numpy.zeros(len(home)))
                single.step(5)
                state = single.state
                self.assertEqual(batch.time[i], state.time)
                for name in FIELDS:
                    numpy.testing.assert_array_equal(arrays[name][i], getattr(state, name), name)
        # The arrays are those of the beginning.
        for name in FIELDS:
            self.assertIs(getattr(batch, name), arrays[name])

    def test_efforts(self):
        batch = stiction.Batch([stiction.Simulation(door()) for _ in range(3)])
        batch.effort[:, 0] = [1.0, 2.0, 3.0]
        batch.step(100)
        inertia = 1.0693333333333333 + 20.0 * 0.4**2
        # Constant accelerations: rounding of 100 steps.
        numpy.testing.assert_allclose(batch.q[:, 0], 0.5 * 0.1**2 / inertia * numpy.array([1, 2, 3]), atol=1e-15)
        self.assertEqual(batch.q.shape, (3, 1))
        self.assertEqual(batch.base_orientation.shape, (3, 4))

    def test_any_number_of_threads(self):
        found = []
        for jobs in (1, 2, 5):
            batch = stiction.Batch([pushed(strength) for strength in (4.0, 8.0, 12.0)], jobs=jobs)
            batch.step(150)
            found.append(batch.q.copy())
        numpy.testing.assert_array_equal(found[0], found[1])
        numpy.testing.assert_array_equal(found[0], found[2])


class Ends(unittest.TestCase):
    def test_runs_end_at_their_times(self):
        simulations = [stiction.Simulation(block(duration=duration)) for duration in (0.05, 0.1)]
        batch = stiction.Batch(simulations)
        self.assertEqual(batch.simulations, simulations)
        batch.step(60)
        self.assertEqual(batch.has_ended.tolist(), [True, False])
        self.assertEqual(batch.time[0], 0.05)
        batch.step(60)
        self.assertEqual(batch.has_ended.tolist(), [True, True])
        self.assertEqual(batch.time.tolist(), [0.05, 0.1])
        self.assertEqual([simulation.outcome for simulation in simulations], ["passed", "passed"])

    def test_restored_simulations(self):
        batch = stiction.Batch([pushed(5.0), pushed(10.0)])
        saved = [simulation.save() for simulation in batch.simulations]
        batch.step(100)
        after = batch.q.copy()
        for simulation, checkpoint in zip(batch.simulations, saved, strict=True):
            simulation.restore(checkpoint)
        batch.refresh()
        self.assertEqual(batch.time.tolist(), [0.0, 0.0])
        batch.step(100)
        numpy.testing.assert_array_equal(batch.q, after)

    def test_refusals(self):
        simulation = stiction.Simulation(block())
        with self.assertRaisesRegex(ValueError, "entry 1 is there twice"):
            stiction.Batch([simulation, simulation])
        with self.assertRaisesRegex(ValueError, "entry 1 has 1 joints, the first has 0"):
            stiction.Batch([simulation, stiction.Simulation(door())])
        with self.assertRaisesRegex(ValueError, "jobs"):
            stiction.Batch([simulation], jobs=0)

    def test_an_empty_batch(self):
        batch = stiction.Batch([])
        batch.step()
        self.assertEqual((len(batch), batch.time.shape), (0, (0,)))


class Threads(unittest.TestCase):
    def test_other_threads_run_while_it_steps(self):
        batch = stiction.Batch([stiction.Simulation(SCENARIOS / "stand.toml") for _ in range(4)])
        with counting() as counted:
            before = counted[0]
            batch.step(1000)
            after = counted[0]
        self.assertGreater(after, before)


if __name__ == "__main__":
    unittest.main()
