"""Measures of series made by hand, whose values are known."""

import math
import unittest
from types import SimpleNamespace

from support import FolderTest, about, body_series, case_data, series

import numpy

from stiction_engines import measure
from stiction_engines.series import Failed, Series, collected, rotation_vectors, rpy, steps_of

Z = [0, 0, 1]


def found(kind, motion, **parameters):
    return float(measure.KINDS[kind](motion.time, motion.bodies["box"], **parameters))


class Distances(unittest.TestCase):
    def setUp(self):
        # Falls back from its greatest height; its path is not straight.
        self.motion = series([0, 1, 2, 4], position=[[1, 1, 1], [2, 1, 3], [3, 2, 2], [4, 5, 1]])

    def test_travel(self):
        self.assertAlmostEqual(found("along", self.motion, direction=[2, 0, 0]), 3)
        self.assertAlmostEqual(found("along", self.motion, direction=[0, -1, 0]), -4)
        self.assertAlmostEqual(found("sideways", self.motion, direction=[1, 0, 0]), 4)
        self.assertAlmostEqual(found("sideways", self.motion, direction=[3, 4, 0]), 0)
        self.assertAlmostEqual(found("travel", self.motion), 5)

    def test_creep_is_the_speed_of_the_second_half(self):
        # From 2 s on: (1, 3, -1) in 2 s.
        self.assertAlmostEqual(found("creep_speed", self.motion), math.sqrt(11) / 2)

    def test_heights(self):
        self.assertAlmostEqual(found("height", self.motion), 1)
        self.assertAlmostEqual(found("greatest_rise", self.motion), 2)
        self.assertAlmostEqual(found("passes_height", self.motion, height=2.5), 0.75)
        self.assertEqual(found("passes_height", self.motion, height=5), math.inf)
        self.assertAlmostEqual(found("greatest_height", self.motion), 3)
        self.assertAlmostEqual(found("greatest_height", self.motion, **{"from": 1.5, "to": 2.5}), 2)

    def test_a_body_that_sinks_does_not_rise(self):
        self.assertEqual(found("greatest_rise", series([0, 1], position=[[0, 0, 1], [0, 0, 0.5]])), 0)

    def test_position_at(self):
        self.assertAlmostEqual(found("position_at", self.motion, at=3, axis=1), 3.5)

    def test_position_distance(self):
        self.assertAlmostEqual(found("position_distance", self.motion, reference={"position": [4, 2, 5]}), 5)

    def test_joints_distance(self):
        motion = series([0, 1], q=[[0, 0], [1, 2]], qd=[[0, 0], [0, 0]])
        self.assertAlmostEqual(found("joints_distance", motion, reference={"q": [1, 0]}), math.sqrt(2))


class Speeds(unittest.TestCase):
    def test_linear(self):
        speeds = [[0, 3, 4], [1, 0, 0], [3, 0, 0], [0, 0, 0]]
        motion = series([0, 1, 2, 3], linear_velocity=speeds)
        # 3, 1, 3, 0 along the floor: below 2 at 0.5 s, above at 1.5 s, below for good at 2 1/3 s.
        self.assertAlmostEqual(found("slower_than", motion, speed=2), 2 + 1 / 3)
        self.assertAlmostEqual(found("speed_at", motion, at=1.5), 2)
        rising = series([0, 1, 2, 3], linear_velocity=speeds[1:] + speeds[:1])
        self.assertAlmostEqual(found("faster_than", rising, speed=2), 0.5)
        self.assertEqual(found("slower_than", rising, speed=2), math.inf)
        self.assertEqual(found("faster_than", rising, speed=9), math.inf)

    def test_angular(self):
        motion = series([0, 1, 2], angular_velocity=[[0, 0, 0], [0, 4, 3], [0, 0, 1]])
        # 0, 3, 1 about the vertical.
        self.assertAlmostEqual(found("turns_faster_than", motion, speed=2), 2 / 3)
        self.assertAlmostEqual(found("turns_slower_than", motion, speed=2), 1.5)
        self.assertEqual(found("turns_slower_than", motion, speed=0.5), math.inf)
        self.assertAlmostEqual(found("turning_speed_at", motion, at=1.5), 3)


class Angles(unittest.TestCase):
    def test_yaw_counts_turns(self):
        angles = numpy.linspace(0, 15, 40)
        self.assertAlmostEqual(found("yaw", series(angles, orientation=about(Z, angles))), 15)
        self.assertAlmostEqual(found("yaw", series(angles, orientation=about(Z, -angles))), 15)

    def test_turned(self):
        angles = [0.2, 1.0, 1.4, 0.5]
        motion = series([0, 1, 2, 3], orientation=about([0.6, 0, 0.8], angles))
        self.assertAlmostEqual(found("turned", motion), 0.3)
        self.assertAlmostEqual(found("greatest_turned", motion), 1.2)
        # Turned by 0, 0.8, 1.2: 0.9 is passed a quarter on the way.
        self.assertAlmostEqual(found("turns_past", motion, angle=0.9), 1.25)
        self.assertAlmostEqual(
            found("orientation_distance", motion, orientation=about([0.6, 0, 0.8], [0.1])[0]), 0.4
        )

    def test_rotation_vectors_take_the_short_way(self):
        turn = rotation_vectors(about(Z, [2 * math.pi - 0.1]), numpy.array([1.0, 0, 0, 0]))
        numpy.testing.assert_allclose(turn, [[0, 0, -0.1]], atol=1e-12)

    def test_rpy_of_a_quaternion(self):
        numpy.testing.assert_allclose(rpy(about([1, 0, 0], [0.3])[0]), [0.3, 0, 0], atol=1e-15)
        numpy.testing.assert_allclose(rpy(about([0, 1, 0], [0.3])[0]), [0, 0.3, 0], atol=1e-15)
        numpy.testing.assert_allclose(rpy(about(Z, [0.3])[0]), [0, 0, 0.3], atol=1e-15)


class Balances(FolderTest):
    """A body of 2 kg with moments of inertia 0.1, 0.2, 0.3 under a gravity of 10 m/s^2."""

    def changes(self, kind, motion):
        data = case_data()
        data["measures"][0] |= {"kind": kind, "truth": 0.25}
        data["measures"][0].pop("direction")
        return measure.errors(self.case(data), motion)["distance"]

    def test_free_fall_keeps_energy_and_momentum(self):
        fall = series([0, 1], position=[[0, 0, 7], [1, 0, 2]], linear_velocity=[[1, 0, 0], [1, 0, -10]])
        self.assertAlmostEqual(self.changes("energy_drift", fall)[0], 0)
        self.assertAlmostEqual(self.changes("momentum_drift", fall)[0], 0)
        self.assertAlmostEqual(self.changes("angular_momentum_drift", fall)[0], 0)

    def test_changes(self):
        motion = series(
            [0, 1],
            position=[[0, 0, 7], [0, 0, 5]],
            linear_velocity=[[0, 0, 0], [0, 0, -9]],
            angular_velocity=[[0, 0, 0], [2, 0, 0]],
        )
        # 2 kg lost 2 m: -40 J; gained 81 J and 0.1 * 4 / 2 J. The error is signed.
        value, error = self.changes("energy_drift", motion)
        self.assertAlmostEqual(value, 41.2)
        self.assertAlmostEqual(error, 40.95)
        self.assertAlmostEqual(self.changes("momentum_drift", motion)[0], 2)
        self.assertAlmostEqual(self.changes("angular_momentum_drift", motion)[0], 0.2)

    def test_every_kind_has_a_function_and_unknown_ones_are_named(self):
        data = case_data()
        data["measures"][0]["kind"] = "colour"
        with self.assertRaisesRegex(ValueError, "`kind` is 'colour', expected one of along, "):
            measure.errors(self.case(data), series([0, 1]))


class SeriesTest(unittest.TestCase):
    def test_numbers_that_are_not_finite_fail(self):
        known = SimpleNamespace(bodies=[SimpleNamespace(name="box")])
        rows = [[body_series(1)], [body_series(1, position=[[0, math.nan, 0]])]]
        with self.assertRaisesRegex(Failed, "the state of box is not finite"):
            collected(known, [0, 1], rows)
        self.assertIsInstance(collected(known, [0], rows[:1]), Series)

    def test_steps_cover_the_duration(self):
        self.assertEqual(steps_of(SimpleNamespace(duration=0.6), 1e-3), 600)
        self.assertEqual(steps_of(SimpleNamespace(duration=0.6), 0.25), 3)


if __name__ == "__main__":
    unittest.main()
