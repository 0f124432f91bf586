"""Bodies in flight: nothing touches."""

import numpy
from scipy.integrate import solve_ivp

from . import robots
from .parts import G, box, box_inertia, case, measure, placed


def cases():
    size, duration, spin = (0.3, 0.2, 0.1), 1.0, [0.5, 6.0, 0.5]
    body, files = box("plate", 1.0, size)
    inertia = numpy.array(box_inertia(1.0, size))

    def motion(_, y):
        """Quaternion and body angular velocity: q' = q w / 2, I w' = I w x w."""
        (w, x, y_, z), rate = y[:4], y[4:]
        p, q, r = rate
        turn = 0.5 * numpy.array(
            [-x * p - y_ * q - z * r, w * p + y_ * r - z * q, w * q + z * p - x * r, w * r + x * q - y_ * p]
        )
        return numpy.concatenate([turn, numpy.cross(inertia * rate, rate) / inertia])

    solved = solve_ivp(motion, [0, duration], [1.0, 0, 0, 0, *spin], method="DOP853", rtol=1e-13, atol=1e-14)
    orientation = (solved.y[:4, -1] / numpy.linalg.norm(solved.y[:4, -1])).tolist()
    yield (
        case(
            "tumbles",
            "A plate tumbles in flight about its middle axis",
            "flight",
            [placed(body, [0, 0, 20], velocity=[1, 0, 0], angular=spin)],
            [],
            duration,
            [
                measure(
                    "orientation_error",
                    "orientation_distance",
                    0.0,
                    "integration of Euler's equations",
                    "rad",
                    error=1e-11,
                    body="plate",
                    orientation=orientation,
                ),
                measure("energy", "energy_drift", 0.0, "nothing but gravity acts", "J", body="plate"),
                measure(
                    "angular_momentum",
                    "angular_momentum_drift",
                    0.0,
                    "no moment acts",
                    "kg m^2/s",
                    body="plate",
                ),
                measure("fall", "height", 20 - G * duration**2 / 2, "h - g t^2 / 2", "m", body="plate"),
            ],
        ),
        files,
    )
    body, files = robots.humanoid()
    joints = list(body["joints"])
    loose = {key: value for key, value in body.items() if key not in ("servos", "armature", "touching")}
    rates = {
        joint: 2.0 * (-1) ** i
        for i, joint in enumerate(joints)
        if "foot" not in joint and "elbow" not in joint
    }
    yield (
        case(
            "humanoid-flies",
            "A humanoid with free joints tumbles in flight",
            "flight",
            [placed(loose, [0, 0, 20], velocity=[1, 0, 2], angular=[1, 2, 0.5], joint_velocities=rates)],
            [],
            0.6,
            [
                measure(
                    "energy",
                    "energy_drift",
                    0.0,
                    "nothing but gravity acts, joints are free",
                    "J",
                    body="humanoid",
                ),
                measure("momentum", "momentum_drift", 0.0, "m g t", "kg m/s", body="humanoid"),
                measure(
                    "angular_momentum",
                    "angular_momentum_drift",
                    0.0,
                    "no moment acts",
                    "kg m^2/s",
                    body="humanoid",
                ),
            ],
        ),
        files,
    )
