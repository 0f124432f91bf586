"""Boxes on slopes and under side loads, below and above the friction angle."""

import math

from .parts import BOX, G, box, case, floor, measure, placed, tilted

MU = 0.5


def cases():
    body, files = box()
    start = [placed(body, [0, 0, BOX[2] / 2])]
    for degrees in [0, 45]:
        heading = math.radians(degrees)
        direction = [math.cos(heading), math.sin(heading), 0]
        below, above = math.atan(0.95 * MU), math.atan(1.5 * MU)
        yield (
            case(
                f"slope-holds-{degrees}",
                f"A box rests on a slope at 0.95 of the friction, which falls {degrees} degrees to its sides",
                "slopes",
                start,
                floor(MU),
                2.0,
                [
                    measure("creep", "creep_speed", 0.0, "tan(slope) = 0.95 mu: it stays", "m/s"),
                    measure("shift", "travel", 0.0, "it stays", "m"),
                ],
                gravity=tilted(below, heading),
            ),
            files,
        )
        time = 0.4
        acceleration = G * (math.sin(above) - MU * math.cos(above))
        yield (
            case(
                f"slope-slides-{degrees}",
                f"A box slides down a slope of 1.5 times the friction, which falls {degrees} degrees to its sides",
                "slopes",
                start,
                floor(MU),
                time,
                [
                    measure(
                        "travel",
                        "along",
                        acceleration * time**2 / 2,
                        "g (sin a - mu cos a) t^2 / 2",
                        "m",
                        direction=direction,
                    ),
                    measure("sideways", "sideways", 0.0, "it slides straight down", "m", direction=direction),
                ],
                gravity=tilted(above, heading),
            ),
            files,
        )
    load = 0.05 * MU * G
    yield (
        case(
            "light-load",
            "A box rests under a side load of 0.05 of the friction",
            "slopes",
            start,
            floor(MU),
            2.0,
            [measure("creep", "creep_speed", 0.0, "the load is 0.05 mu m g: it stays", "m/s")],
            forces=[
                {
                    "body": "box",
                    "link": "box",
                    "point": [0, 0, -BOX[2] / 2],
                    "knots": [[0.0, load, 0, 0, 0, 0, 0], [2.0, load, 0, 0, 0, 0, 0]],
                }
            ],
        ),
        files,
    )
