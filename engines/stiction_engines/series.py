"""Time series of a run: the states of all bodies at the start and at the end of each step."""

import math
from dataclasses import dataclass

import numpy


class Failed(Exception):
    """The engine gave up, or a number is no longer finite."""


@dataclass
class BodySeries:
    """States of a body, one row per instant; quantities as in `engine.BodyState`."""

    position: numpy.ndarray
    orientation: numpy.ndarray
    linear_velocity: numpy.ndarray
    angular_velocity: numpy.ndarray
    q: numpy.ndarray
    qd: numpy.ndarray

    @property
    def turning(self):
        """Rotation since the start: a rotation vector per instant, world axes; its length is at most pi."""
        return rotation_vectors(self.orientation, self.orientation[0])


@dataclass
class Series:
    """A run."""

    time: numpy.ndarray
    bodies: dict[str, BodySeries]


def product(a, b):
    """Products of quaternions w, x, y, z, row by row."""
    a, b = numpy.atleast_2d(a), numpy.atleast_2d(b)
    w = a[:, 0] * b[:, 0] - numpy.sum(a[:, 1:] * b[:, 1:], axis=1)
    v = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + numpy.cross(a[:, 1:], b[:, 1:])
    return numpy.column_stack([w, v])


def rotation_vectors(orientation, since):
    """Rotation vectors from `since` to each orientation, world axes."""
    relative = product(orientation, numpy.asarray(since) * [1, -1, -1, -1])
    relative *= numpy.where(relative[:, :1] < 0, -1.0, 1.0)
    length = numpy.linalg.norm(relative[:, 1:], axis=1)
    angle = 2.0 * numpy.arctan2(length, relative[:, 0])
    scale = numpy.where(length > 1e-12, angle / numpy.maximum(length, 1e-300), 2.0)
    return relative[:, 1:] * scale[:, None]


def matrix(quaternion):
    """The rotation matrix of a unit quaternion."""
    w, x, y, z = quaternion
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rpy(quaternion):
    """Roll, pitch, yaw of a unit quaternion, as in URDF."""
    m = matrix(quaternion)
    cosine = math.hypot(m[0, 0], m[1, 0])
    pitch = math.atan2(-m[2, 0], cosine)
    if cosine < 1e-9:
        return [math.atan2(-m[1, 2], m[1, 1]), pitch, 0.0]
    return [math.atan2(m[2, 1], m[2, 2]), pitch, math.atan2(m[1, 0], m[0, 0])]


FIELDS = ["position", "orientation", "linear_velocity", "angular_velocity", "q", "qd"]


def collected(case, time, states):
    """The series of rows of states. Raises `Failed` where a number is not finite."""
    bodies = {}
    for k, body in enumerate(case.bodies):
        rows = {
            field: numpy.array([getattr(row[k], field) for row in states], dtype=float) for field in FIELDS
        }
        bodies[body.name] = BodySeries(**rows)
        if not all(numpy.isfinite(values).all() for values in rows.values()):
            raise Failed(f"the state of {body.name} is not finite")
    return Series(numpy.array(time, dtype=float), bodies)


def steps_of(case, step):
    """Number of steps that cover the duration of a case."""
    return math.ceil(case.duration / step - 1e-9)


def recorded(case, simulation, step):
    """Runs a simulation over the duration of its case, step by step."""
    time, states = [simulation.time], [simulation.states()]
    for _ in range(steps_of(case, step)):
        simulation.advance(1)
        time.append(simulation.time)
        states.append(simulation.states())
    return collected(case, time, states)
