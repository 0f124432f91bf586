"""Balls that roll."""

import math

from .parts import G, case, floor, measure, placed, sphere, tilted


def cases():
    body, files = sphere()
    radius, angle, time = 0.1, math.radians(20), 0.6
    yield (
        case(
            "ball-rolls-down",
            "A ball rolls down a slope of 20 degrees",
            "rolling",
            [placed(body, [0, 0, radius])],
            floor(0.5, ["ball"]),
            time,
            [
                measure(
                    "travel",
                    "along",
                    5 / 7 * G * math.sin(angle) * time**2 / 2,
                    "5/7 g sin(a) t^2 / 2: 2/7 tan(a) < mu",
                    "m",
                    body="ball",
                    direction=[1, 0, 0],
                ),
            ],
            gravity=tilted(angle),
        ),
        files,
    )
    mu, speed, duration = 0.2, 2.0, 0.6
    rolls = 2 * speed / (7 * mu * G)
    yield (
        case(
            "ball-begins-to-roll",
            "A ball slides at 2 m/s until it rolls",
            "rolling",
            [placed(body, [0, 0, radius], velocity=[speed, 0, 0])],
            floor(mu, ["ball"]),
            duration,
            [
                measure("speed", "speed_at", 5 / 7 * speed, "5/7 v", "m/s", body="ball", at=duration),
                measure(
                    "travel",
                    "along",
                    speed * rolls - mu * G * rolls**2 / 2 + 5 / 7 * speed * (duration - rolls),
                    "v t - mu g t^2 / 2 up to t = 2 v / (7 mu g), then 5/7 v t",
                    "m",
                    body="ball",
                    direction=[1, 0, 0],
                ),
            ],
        ),
        files,
    )
