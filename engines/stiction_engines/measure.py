"""Measures of a series, the same for every engine. Distances in m, angles in rad, times in s.

Each kind is a function of the series of the measured body, with the parameters of the measure.
"""

import numpy

from .mechanics import Mechanism
from .series import rotation_vectors


def _unit(direction):
    direction = numpy.asarray(direction, dtype=float)
    return direction / numpy.linalg.norm(direction)


def along(time, body, direction):
    """Travel of the origin along a direction."""
    return (body.position[-1] - body.position[0]) @ _unit(direction)


def sideways(time, body, direction):
    """Distance of the origin at the end from the line of a horizontal direction through its start."""
    shift = (body.position[-1] - body.position[0])[:2]
    return numpy.linalg.norm(shift - (shift @ _unit(direction)[:2]) * _unit(direction)[:2])


def travel(time, body):
    """Distance of the origin from its start."""
    return numpy.linalg.norm(body.position[-1] - body.position[0])


def creep_speed(time, body):
    """Mean speed of the origin over the second half of the run, by its displacement."""
    half = numpy.searchsorted(time, time[-1] / 2)
    return numpy.linalg.norm(body.position[-1] - body.position[half]) / (time[-1] - time[half])


def _crossing(time, values, level, last):
    """Instant at which `values` cross `level`, interpolated: the first one, or the last one; infinite without."""
    above = values > level
    changes = numpy.nonzero(above[1:] != above[:-1])[0]
    if len(changes) == 0:
        return numpy.inf
    k = changes[-1 if last else 0]
    return time[k] + (time[k + 1] - time[k]) * (level - values[k]) / (values[k + 1] - values[k])


def slower_than(time, body, speed):
    """Instant from which on the origin is slower along the floor than `speed`."""
    speeds = numpy.linalg.norm(body.linear_velocity[:, :2], axis=1)
    return numpy.inf if speeds[-1] > speed else _crossing(time, speeds, speed, last=True)


def faster_than(time, body, speed):
    """First instant at which the origin is faster along the floor than `speed`. Soft floors sink at the start."""
    return _crossing(time, numpy.linalg.norm(body.linear_velocity[:, :2], axis=1), speed, last=False)


def turns_slower_than(time, body, speed):
    """Instant from which on the body turns slower about the vertical than `speed`, rad/s."""
    speeds = numpy.abs(body.angular_velocity[:, 2])
    return numpy.inf if speeds[-1] > speed else _crossing(time, speeds, speed, last=True)


def turns_faster_than(time, body, speed):
    """First instant at which the body turns faster about the vertical than `speed`, rad/s."""
    return _crossing(time, numpy.abs(body.angular_velocity[:, 2]), speed, last=False)


def height(time, body):
    """Height of the origin at the end."""
    return body.position[-1, 2]


def passes_height(time, body, height):
    """First instant at which the origin passes a height."""
    return _crossing(time, body.position[:, 2], height, last=False)


def greatest_rise(time, body):
    """Greatest height of the origin above its start."""
    return max(0.0, (body.position[:, 2] - body.position[0, 2]).max())


def greatest_height(time, body, **span):
    """Greatest height of the origin from one instant to another."""
    within = (time >= span.get("from", 0.0)) & (time <= span.get("to", numpy.inf))
    return body.position[within, 2].max()


def yaw(time, body):
    """Angle turned about z, all turns counted."""
    w, _, _, z = body.orientation.T
    return numpy.ptp(numpy.unwrap(2 * numpy.arctan2(z, w), period=2 * numpy.pi)[[0, -1]])


def turned(time, body):
    """Angle between the orientations at start and end."""
    return numpy.linalg.norm(body.turning[-1])


def greatest_turned(time, body):
    """Greatest angle from the orientation at the start."""
    return numpy.linalg.norm(body.turning, axis=1).max()


def turns_past(time, body, angle):
    """First instant at which the body has turned by an angle since its start."""
    return _crossing(time, numpy.linalg.norm(body.turning, axis=1), angle, last=False)


def speed_at(time, body, at):
    """Speed of the origin at an instant."""
    return numpy.interp(at, time, numpy.linalg.norm(body.linear_velocity, axis=1))


def turning_speed_at(time, body, at):
    """Angular speed at an instant, rad/s."""
    return numpy.interp(at, time, numpy.linalg.norm(body.angular_velocity, axis=1))


def position_at(time, body, at, axis):
    """A coordinate of the origin at an instant; `axis` is 0, 1 or 2."""
    return numpy.interp(at, time, body.position[:, axis])


def orientation_distance(time, body, orientation):
    """Angle from an orientation to that at the end."""
    return numpy.linalg.norm(rotation_vectors(body.orientation[-1:], orientation)[0])


def position_distance(time, body, reference):
    """Distance of the origin at the end from that of a reference."""
    return numpy.linalg.norm(body.position[-1] - reference["position"])


def joints_distance(time, body, reference):
    """Root mean square of the differences of joint positions at the end from those of a reference."""
    return float(numpy.sqrt(numpy.mean((body.q[-1] - reference["q"]) ** 2)))


KINDS = {
    kind.__name__: kind
    for kind in [
        along,
        sideways,
        travel,
        creep_speed,
        slower_than,
        faster_than,
        turns_slower_than,
        turns_faster_than,
        height,
        passes_height,
        greatest_rise,
        greatest_height,
        yaw,
        turned,
        greatest_turned,
        turns_past,
        speed_at,
        turning_speed_at,
        position_at,
        orientation_distance,
        position_distance,
        joints_distance,
    ]
}


def _changes(case, series, measure):
    """Changes of energy, momentum and angular momentum about the centre of mass, from start to end, of a body."""
    body = case.body(measure.body)
    mechanism, motion = Mechanism(body), series.bodies[body.name]
    ends = [mechanism.totals(motion, k, case.gravity) for k in (0, len(series.time) - 1)]
    kinetic, potential, momentum, angular, centre = (ends[1][i] - ends[0][i] for i in range(5))
    about_centre = [a - numpy.cross(c, p) for _, _, p, a, c in ends]
    elapsed = series.time[-1] - series.time[0]
    return {
        "energy_drift": kinetic + potential,
        "momentum_drift": numpy.linalg.norm(momentum - mechanism.mass * case.gravity * elapsed),
        "angular_momentum_drift": numpy.linalg.norm(about_centre[1] - about_centre[0]),
    }


MECHANICAL = ["energy_drift", "momentum_drift", "angular_momentum_drift"]


def value(case, series, measure):
    """The value of a measure."""
    if measure.kind in MECHANICAL:
        return float(_changes(case, series, measure)[measure.kind])
    if measure.kind not in KINDS:
        raise ValueError(
            f"{case.file}: `kind` is {measure.kind!r}, expected one of {', '.join([*KINDS, *MECHANICAL])}"
        )
    return float(KINDS[measure.kind](series.time, series.bodies[measure.body], **measure.parameters))


def errors(case, series):
    """Values and signed errors of all measures by name; the run ends at the duration of the case."""
    found = {measure.name: value(case, series, measure) for measure in case.measures}
    return {m.name: (found[m.name], found[m.name] - m.truth) for m in case.measures}
