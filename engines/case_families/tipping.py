"""Bodies that turn about a point or an edge on the floor."""

import math

from scipy.integrate import quad, solve_ivp

from .parts import G, about, box, case, floor, measure, placed, urdf

SIZE = (0.1, 0.1, 0.4)
HALF_WIDTH, HALF_HEIGHT = SIZE[0] / 2, SIZE[2] / 2
REACH = math.hypot(HALF_WIDTH, HALF_HEIGHT)  # from the edge to the centre, m
LEAN = math.atan(HALF_WIDTH / HALF_HEIGHT)  # of the diagonal in the upright box
EDGE_INERTIA = 4 / 3 * REACH**2  # per mass: of a box about its edge


def leaning(body, angle):
    """The box turned by `angle` about its lower edge at x = half its width, and lifted onto it."""
    # The diagonal from the edge to the centre stands at `angle - LEAN` beyond the vertical.
    tilt = angle - LEAN
    x, z = HALF_WIDTH + REACH * math.sin(tilt), REACH * math.cos(tilt)
    return placed(body, [x, 0, z], about([0, 1, 0], angle))


def cases():
    body, files = box("tower", 1.0, SIZE)
    start, end = 0.4, 0.75
    rate = 2 * G * REACH / EDGE_INERTIA
    speed = lambda tilt: math.sqrt(rate * (math.cos(start - LEAN) - math.cos(tilt)))
    # With u^2 = tilt - start the integrand is smooth where the speed is 0.
    first = start - LEAN
    time, _ = quad(
        lambda u: 2 * u / speed(first + u * u) if u > 0 else 2 / math.sqrt(rate * math.sin(first)),
        0,
        math.sqrt(end - start),
        epsabs=1e-13,
        epsrel=1e-13,
    )
    yield (
        case(
            "tips-over",
            "A tall box leans on its edge beyond the balance and falls over",
            "tipping",
            [leaning(body, start)],
            floor(1.0, ["tower"]),
            0.4,
            [
                measure(
                    "time_of_turn",
                    "turns_past",
                    time,
                    "a pendulum about its edge: integral of d(angle) / sqrt(2 g R (cos first - cos tilt) / (4/3 R^2)); the "
                    "load on the edge stays within the friction",
                    "s",
                    error=1e-12,
                    body="tower",
                    angle=end - start,
                ),
            ],
        ),
        files,
    )
    start = 0.15
    drop = math.cos(start - LEAN) - math.cos(LEAN)
    ratio = 1 - 1.5 * math.sin(LEAN) ** 2
    other = LEAN - math.acos(math.cos(LEAN) + ratio**2 * drop)
    yield (
        case(
            "rocks",
            "A tall box falls from one edge and rises on the other",
            "tipping",
            [leaning(body, start)],
            floor(1.0, ["tower"]),
            1.0,
            [
                measure(
                    "turn",
                    "greatest_turned",
                    start + other,
                    "Housner: the impact leaves 1 - 3/2 sin^2(a) of the angular velocity, a = atan(width / height); energy "
                    "before and after",
                    "rad",
                    body="tower",
                ),
            ],
        ),
        files,
    )

    # A slender rod of 1 m and 1 kg, its tip on the floor; its frame is at its centre and its axis is z.
    half, mu, speed, duration = 0.5, 1.0, 5.0, 0.1
    rod = {
        "name": "rod",
        "urdf": "rod.urdf",
        "touching": {"rod": [{"kind": "points", "points": [[0, 0, -half]]}]},
    }
    slender = 1.0 * (2 * half) ** 2 / 12
    files = {"rod.urdf": urdf("rod", 1.0, (slender, slender, 1e-4))}
    lean = math.pi / 2 - math.atan(2.0)  # from the vertical; its angle with the floor has tan 2

    def motion(_, y):
        """x of the centre, lean, and their rates; the tip slides towards -x and its height is 0."""
        _, a, vx, w = y
        s, c = math.sin(a), math.cos(a)
        # Centre at height half cos(a); the tip is half sin(a) behind it (towards -x). Unknown: normal force n.
        # m x'' = mu n; m z'' = n - m g, z'' = -half (s w' + c w^2); I a'' = n half s - mu n half c (about +y).
        turn = half * (s - mu * c) / slender
        n = (G - half * c * w * w) / (1 + half * s * turn)
        return [vx, w, mu * n, n * turn]

    solved = solve_ivp(
        motion, [0, duration], [0.0, lean, -speed, 0.0], method="DOP853", rtol=1e-13, atol=1e-14
    )
    x, a, vx, w = solved.y[:, -1]
    pushed = placed(rod, [0, 0, half * math.cos(lean)], about([0, 1, 0], lean), velocity=[-speed, 0, 0])
    derivation = "integration of planar motion with its tip on the floor, mu below 4/3, the least at which a rod can jam"
    yield (
        case(
            "rod-slides",
            "A leaning rod is pushed over the floor, tip first, below Painleve's friction",
            "tipping",
            [pushed],
            floor(mu, ["rod"]),
            duration,
            [
                measure(
                    "shift", "position_at", x, derivation, "m", error=1e-11, body="rod", at=duration, axis=0
                ),
                measure("turn", "turned", abs(a - lean), derivation, "rad", error=1e-11, body="rod"),
            ],
        ),
        files,
    )
    # Jammed: the impulse at the tip keeps the angular momentum about it: w = 3 v sin(floor angle) / (4 half).
    mu, speed = 2.0, 0.5
    rate = -3 * speed * math.cos(lean) / (4 * half)
    solved = solve_ivp(
        lambda _, y: [y[1], 3 * G * math.sin(y[0]) / (4 * half)],
        [0, duration],
        [lean, rate],
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
    )
    a = solved.y[0, -1]
    pushed = placed(rod, [0, 0, half * math.cos(lean)], about([0, 1, 0], lean), velocity=[-speed, 0, 0])
    yield (
        case(
            "rod-jams",
            "A leaning rod is pushed over the floor, tip first, above Painleve's friction, and jams",
            "tipping",
            [pushed],
            floor(mu, ["rod"]),
            duration,
            [
                measure(
                    "turn",
                    "turned",
                    abs(a - lean),
                    "no finite force lets it slide (mu > 4/3): the tip stops at once and keeps the angular momentum about "
                    "it; then a pendulum about its tip",
                    "rad",
                    error=1e-11,
                    body="rod",
                ),
            ],
        ),
        files,
    )
