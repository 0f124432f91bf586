"""Bodies that fall on the floor."""

import math

from .parts import BOX, G, box, case, floor, measure, placed, sphere


def cases():
    body, files = box()
    height = 0.5
    yield (
        case(
            "drop",
            "A box falls 0.5 m on its face and stays there",
            "falling",
            [placed(body, [0, 0, height + BOX[2] / 2])],
            floor(0.5),
            1.0,
            [
                measure("rest_height", "height", BOX[2] / 2, "half its height: nothing below the floor", "m"),
                measure(
                    "fall_time",
                    "passes_height",
                    math.sqrt(2 * (height - 0.05) / G),
                    "sqrt(2 (h - 0.05) / g), when its bottom passes 0.05 m",
                    "s",
                    height=BOX[2] / 2 + 0.05,
                ),
                measure(
                    "rebound",
                    "greatest_height",
                    BOX[2] / 2,
                    "it does not bounce: half its height at 0.4 s and later",
                    "m",
                    **{"from": 0.4},
                ),
            ],
        ),
        files,
    )
    ball, files = sphere()
    radius, height, e = 0.1, 0.5, 0.5
    fall = math.sqrt(2 * height / G)
    yield (
        case(
            "bounce",
            "A ball with restitution 0.5 falls 0.5 m and bounces",
            "falling",
            [placed(ball, [0, 0, height + radius])],
            floor(0.5, ["ball"]),
            0.8,
            [
                measure(
                    "bounce_height",
                    "greatest_height",
                    radius + e**2 * height,
                    "r + e^2 h: the top of the first bounce",
                    "m",
                    body="ball",
                    **{"from": fall + 0.02, "to": fall * (1 + 2 * e) - 0.02},
                ),
            ],
            restitution=e,
        ),
        files,
    )
