"""Boxes that slide to rest, and one that must not leave the floor."""

import math

from .parts import BOX, G, box, case, floor, measure, placed

MU = 0.5
SPEED = 2.0
# Speed below which a body counts as stopped, m/s.
STOPPED = 1e-3


def cases():
    body, files = box()
    for degrees in [0, 22.5, 45, 67.5]:
        heading = math.radians(degrees)
        direction = [math.cos(heading), math.sin(heading), 0]
        velocity = [SPEED * x for x in direction]
        name = f"slide-{degrees:g}".replace(".", "_")
        yield (
            case(
                name,
                f"A box slides at 2 m/s, {degrees:g} degrees to its sides, and stops",
                "sliding",
                [placed(body, [0, 0, BOX[2] / 2], velocity=velocity)],
                floor(MU),
                0.6,
                [
                    measure(
                        "stop_distance",
                        "along",
                        SPEED**2 / (2 * MU * G),
                        "v^2 / (2 mu g)",
                        "m",
                        direction=direction,
                    ),
                    measure(
                        "sideways", "sideways", 0.0, "friction opposes the velocity", "m", direction=direction
                    ),
                    measure(
                        "stop_time",
                        "slower_than",
                        (SPEED - STOPPED) / (MU * G),
                        "(v - 1 mm/s) / (mu g): when its speed falls below 1 mm/s for good",
                        "s",
                        speed=STOPPED,
                    ),
                ],
            ),
            files,
        )
    speed, duration = 6.0, 0.5
    yield (
        case(
            "fast-slide",
            "A box at 6 m/s stays flat on the floor",
            "sliding",
            [placed(body, [0, 0, BOX[2] / 2], velocity=[speed, 0, 0])],
            floor(MU),
            duration,
            [
                measure(
                    "hop",
                    "greatest_rise",
                    0.0,
                    "mu < width / height: it neither tips nor leaves the floor",
                    "m",
                ),
                measure(
                    "travel",
                    "along",
                    speed * duration - MU * G * duration**2 / 2,
                    "v t - mu g t^2 / 2",
                    "m",
                    direction=[1, 0, 0],
                ),
            ],
        ),
        files,
    )
