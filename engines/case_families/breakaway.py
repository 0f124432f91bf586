"""Loads that rise until a body slips, and bodies that spin to rest.

Turning bodies are stools: a plate on three points with its centre of mass in their plane, so that each point carries
a third of the weight whatever the motion, and friction is a function of velocity v and angular velocity w alone:
sum of -mu m g / 3 (v + w x r_i) / |v + w x r_i|. With four points their loads would not be unique.
"""

import math

import numpy
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from .parts import BOX, G, box, case, floor, measure, placed, urdf, rising

MU = 0.5
RADIUS = 0.15  # of the circle of points, m
CLEARANCE = 0.02  # height of the stool's frame above the floor, m
INERTIA = 0.02  # about z, kg m^2
POINTS = numpy.array([[RADIUS * math.cos(a), RADIUS * math.sin(a)] for a in numpy.radians([90, 210, 330])])
SHARE = MU * G / 3  # capacity of a point, N; the stool has 1 kg
SLIPPING = 1e-3  # m/s
TURNING = 1e-2  # rad/s


def stool():
    body = {
        "name": "stool",
        "urdf": "stool.urdf",
        "touching": {
            "stool": [{"kind": "points", "points": [[x, y, -CLEARANCE] for x, y in POINTS.tolist()]}]
        },
    }
    return body, {"stool.urdf": urdf("stool", 1.0, (0.01, 0.01, INERTIA), com=(0, 0, -CLEARANCE))}


def friction(twist):
    """Friction of the three points on the stool that moves by (vx, vy, w): force and moment about its centre."""
    vx, vy, w = twist
    speeds = numpy.column_stack([vx - w * POINTS[:, 1], vy + w * POINTS[:, 0]])
    forces = -SHARE * speeds / numpy.linalg.norm(speeds, axis=1)[:, None]
    return numpy.array(
        [*forces.sum(axis=0), (POINTS[:, 0] * forces[:, 1] - POINTS[:, 1] * forces[:, 0]).sum()]
    )


def rotated_friction(y):
    """Friction at position x, y, angle and velocity, world axes: that of the stool turned back."""
    c, s = math.cos(y[2]), math.sin(y[2])
    fx, fy, moment = friction([c * y[3] + s * y[4], -s * y[3] + c * y[4], y[5]])
    return numpy.array([c * fx - s * fy, s * fx + c * fy, moment])


def slopes(y):
    """Derivatives of the motion by its state, without those by the angle, which the implicit integration can miss."""
    c, s = math.cos(y[2]), math.sin(y[2])
    jacobian = numpy.zeros((6, 6))
    jacobian[:3, 3:] = numpy.eye(3)
    for px, py in POINTS:
        arm = numpy.array([c * px - s * py, s * px + c * py])
        to_speed = numpy.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]])
        speed = to_speed @ y[3:]
        norm = numpy.linalg.norm(speed)
        along = speed / norm
        jacobian[3:, 3:] -= SHARE / norm * to_speed.T @ (numpy.eye(2) - numpy.outer(along, along)) @ to_speed
    jacobian[3:, 3:] /= MASSES[:, None]
    return jacobian


MASSES = numpy.array([1.0, 1.0, INERTIA])


def breakaway(load):
    """The factor of a load at which the stool slips, and the twist with which it begins to.

    By the upper bound of limit analysis the factor is the least of dissipation over the power of the load.
    """
    scale = numpy.array([1.0, 1.0, 1 / RADIUS])

    def factor(free):
        # Twists whose power with the load is 1.
        twist = numpy.array([free[0], 0.0, free[1]]) * scale
        twist[1] = (1.0 - load[2] * twist[2] - load[0] * twist[0]) / load[1]
        return -friction(twist) @ twist, twist

    best = minimize(
        lambda free: factor(free)[0],
        [1e-3, 0.5 * RADIUS / load[2]],
        method="Nelder-Mead",
        options={"xatol": 1e-12, "fatol": 1e-15, "maxiter": 10_000, "maxfev": 10_000},
    )
    return factor(best.x)


def cases():
    body, files = box()
    rate = 1.5 * MU * G  # N/s
    for degrees in [0, 45]:
        heading = math.radians(degrees)
        direction = [math.cos(heading), math.sin(heading), 0]
        duration = 0.8
        slip = MU * G / rate
        yield (
            case(
                f"breakaway-{degrees}",
                f"A side load rises until a box slips, {degrees} degrees to its sides",
                "breakaway",
                [placed(body, [0, 0, BOX[2] / 2])],
                floor(MU),
                duration,
                [
                    measure(
                        "breakaway_time",
                        "faster_than",
                        slip + math.sqrt(2 * SLIPPING / rate),
                        "load rate c: it slips at mu m g / c and reaches v after sqrt(2 v m / c)",
                        "s",
                        speed=SLIPPING,
                    ),
                    measure(
                        "travel",
                        "along",
                        rate * (duration - slip) ** 3 / 6,
                        "c (t - t_slip)^3 / (6 m)",
                        "m",
                        direction=direction,
                    ),
                ],
                forces=[rising("box", -BOX[2] / 2, (rate * direction[0], rate * direction[1], 0))],
            ),
            files,
        )

    body, files = stool()
    start = [0, 0, CLEARANCE]
    rate, duration = 1.5 * MU * G * RADIUS, 0.8
    slip = MU * G * RADIUS / rate
    push = lambda force, moment: rising("stool", -CLEARANCE, (0, force, 0), (0, 0, moment))
    yield (
        case(
            "breakaway-turn",
            "A moment about the vertical rises until a stool on three points turns",
            "breakaway",
            [placed(body, start)],
            floor(MU, ["stool"]),
            duration,
            [
                measure(
                    "breakaway_time",
                    "turns_faster_than",
                    slip + math.sqrt(2 * TURNING * INERTIA / rate),
                    "moment rate c: it turns at mu m g r / c and reaches w after sqrt(2 w I / c)",
                    "s",
                    body="stool",
                    speed=TURNING,
                ),
                measure(
                    "angle",
                    "yaw",
                    rate * (duration - slip) ** 3 / (6 * INERTIA),
                    "c (t - t_slip)^3 / (6 I)",
                    "rad",
                    body="stool",
                ),
            ],
            forces=[push(0.0, rate)],
        ),
        files,
    )

    # Force and moment together, at 1.5 and 0.8 of their own capacities after 1 s: the stool turns about no point.
    load = numpy.array([0.0, 1.5 * MU * G, 0.8 * MU * G * RADIUS])
    slip, twist = breakaway(load)
    begin = 1e-4
    # Just after t_slip the twist grows as a tau^2 along its first direction n: 2 a n.M n = n.load.
    growth = load @ twist / (2 * twist @ (MASSES * twist))
    motion = solve_ivp(
        lambda tau, y: [*y[3:], *((load * (slip + tau) + rotated_friction(y)) / MASSES)],
        [begin, duration - slip],
        [0.0, 0.0, 0.0, *(growth * begin**2 * twist)],
        method="Radau",
        rtol=1e-10,
        atol=1e-15,
        jac=lambda tau, y: slopes(y),
        events=[lambda tau, y: math.hypot(y[3], y[4]) - SLIPPING],
    )
    x, y, angle = motion.y[:3, -1]
    derivation = (
        "limit analysis of three points with mu m g / 3 each; after it, integration of planar motion (module "
        "breakaway of make_cases.py)"
    )
    yield (
        case(
            "breakaway-combined",
            "A force and a moment rise together until a stool on three points slips",
            "breakaway",
            [placed(body, start)],
            floor(MU, ["stool"]),
            duration,
            [
                measure(
                    "breakaway_time",
                    "faster_than",
                    slip + motion.t_events[0][0],
                    derivation,
                    "s",
                    error=1e-8,
                    body="stool",
                    speed=SLIPPING,
                ),
                measure("travel", "travel", math.hypot(x, y), derivation, "m", error=1e-8, body="stool"),
                measure("angle", "yaw", abs(angle), derivation, "rad", error=1e-7, body="stool"),
            ],
            forces=[push(load[1], load[2])],
        ),
        files,
    )

    spin = 6.0
    stop = spin * INERTIA / (MU * G * RADIUS)
    yield (
        case(
            "spin",
            "A stool on three points spins at 6 rad/s to rest",
            "breakaway",
            [placed(body, start, angular=[0, 0, spin])],
            floor(MU, ["stool"]),
            0.4,
            [
                measure("angle", "yaw", spin * stop / 2, "w^2 I / (2 mu m g r)", "rad", body="stool"),
                measure(
                    "stop_time",
                    "turns_slower_than",
                    stop * (1 - TURNING / spin),
                    "(w - 0.01 rad/s) I / (mu m g r)",
                    "s",
                    body="stool",
                    speed=TURNING,
                ),
            ],
        ),
        files,
    )

    # Up to shortly before a point stops, about which the stool then turns.
    speed, spin, duration = 1.0, 10.0, 0.28
    motion = solve_ivp(
        lambda t, y: [*y[3:], *(rotated_friction(y) / MASSES)],
        [0, duration],
        [0.0, 0, 0, speed, 0, spin],
        method="Radau",
        rtol=1e-11,
        atol=1e-13,
        jac=lambda t, y: slopes(y),
    )
    x, y, angle = motion.y[:3, -1]
    derivation = (
        "integration of planar motion with the friction of three points (module breakaway of make_cases.py)"
    )
    yield (
        case(
            "slide-with-spin",
            "A stool on three points slides at 1 m/s, spinning at 10 rad/s",
            "breakaway",
            [placed(body, start, velocity=[speed, 0, 0], angular=[0, 0, spin])],
            floor(MU, ["stool"]),
            duration,
            [
                measure("travel", "along", x, derivation, "m", error=1e-8, body="stool", direction=[1, 0, 0]),
                measure(
                    "drift", "position_at", y, derivation, "m", error=1e-8, body="stool", at=duration, axis=1
                ),
                measure("angle", "yaw", abs(angle), derivation, "rad", error=1e-7, body="stool"),
            ],
        ),
        files,
    )
