"""Boxes on boxes."""

from .parts import G, box, case, floor, measure, placed, rising

SLIPPING = 1e-3  # m/s


def cases():
    lower, files = box("lower", 2.0, (0.4, 0.4, 0.1))
    upper, more = box("upper", 1.0, (0.2, 0.2, 0.1))
    files = files | more
    start = [placed(lower, [0, 0, 0.05]), placed(upper, [0, 0, 0.15])]
    on_floor, between = 0.6, 0.4
    friction = floor(on_floor, ["lower"]) + [
        {"bodies": ["lower", "upper"], "static": between, "kinetic": between}
    ]
    ramp = lambda body, rate: rising(body, -0.05, force=(rate, 0, 0))
    rate, duration = 6.0, 0.8
    slip = between * 1.0 * G / rate
    yield (
        case(
            "upper-box-slips",
            "A side load on the upper of two boxes rises until it slips on the lower one",
            "stacked",
            start,
            friction,
            duration,
            [
                measure(
                    "breakaway_time",
                    "faster_than",
                    slip + (2 * SLIPPING / rate) ** 0.5,
                    "load rate c: it slips at mu m g / c and reaches v after sqrt(2 v m / c)",
                    "s",
                    body="upper",
                    speed=SLIPPING,
                ),
                measure(
                    "travel",
                    "travel",
                    rate * (duration - slip) ** 3 / 6,
                    "c (t - t_slip)^3 / (6 m)",
                    "m",
                    body="upper",
                ),
                measure(
                    "lower_travel",
                    "travel",
                    0.0,
                    "mu m g < mu_floor (m + m_lower) g: the lower one rests",
                    "m",
                    body="lower",
                ),
            ],
            forces=[ramp("upper", rate)],
        ),
        files,
    )
    # The lower box slips on the floor at F1; both accelerate together until the upper one slips at F2.
    rate, duration = 50.0, 0.8
    first = on_floor * 3.0 * G / rate
    second = (on_floor * 3.0 * G + 3.0 * between * G) / rate
    apart = duration - second
    # Together: 3 v' = rate (t - first). Apart: upper v' = mu g; lower 2 v' = rate t - floor - mu m g.
    span = second - first
    speed, place = rate * span**2 / 6, rate * span**3 / 18
    upper_travel = place + speed * apart + between * G * apart**2 / 2
    start_load = rate * second - on_floor * 3.0 * G - between * G
    lower_travel = place + speed * apart + start_load / 2 * apart**2 / 2 + rate / 2 * apart**3 / 6
    derivation = "three phases: both rest, both slide as one, the upper one slips on the lower one"
    yield (
        case(
            "lower-box-pulled-away",
            "A side load on the lower of two boxes rises until both slide, then until the upper one slips",
            "stacked",
            start,
            friction,
            duration,
            [
                measure("upper_travel", "travel", upper_travel, derivation, "m", body="upper"),
                measure("lower_travel", "travel", lower_travel, derivation, "m", body="lower"),
            ],
            forces=[ramp("lower", rate)],
        ),
        files,
    )
    names = [f"brick{i}" for i in range(1, 6)]
    stack, files = [], {}
    for i, name in enumerate(names):
        one, text = box(name, 1.0, (0.2, 0.2, 0.1))
        stack.append(placed(one, [0, 0, 0.05 + 0.1 * i]))
        files |= text
    pairs = [{"bodies": list(pair), "static": 0.5, "kinetic": 0.5} for pair in zip(names, names[1:])]
    yield (
        case(
            "stack-stands",
            "Five boxes stand on each other",
            "stacked",
            stack,
            floor(0.5, names[:1]) + pairs,
            2.0,
            [
                measure("height", "height", 0.45, "boxes of 0.1 m: nothing overlaps", "m", body="brick5"),
                measure("creep", "creep_speed", 0.0, "it stands", "m/s", body="brick5"),
            ],
        ),
        files,
    )
