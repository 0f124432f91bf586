"""Draws error over cost of a comparison as SVG: one panel per measure, one curve per engine and settings."""

import math
from pathlib import Path
from xml.sax.saxutils import escape

from . import rows

#: Panels: case, measure, title, unit.
PANELS = [
    ("slide-0", "stop_distance", "Stop distance along the sides", "m"),
    ("slide-45", "stop_distance", "Stop distance along the diagonal", "m"),
    ("slope-holds-0", "creep", "Creep on a slope, 0.95 of the friction", "m/s"),
    ("breakaway-combined", "travel", "Travel after a combined break-away", "m"),
    ("rocks", "turn", "Turn of a rocking box", "rad"),
    ("humanoid-pushed", "position_error", "Position of a pushed humanoid", "m"),
]
COLOURS = ["#0b6e4f", "#c1440e", "#2b5da8", "#8b3fa0", "#b8860b", "#555555", "#d1477a", "#1b8a9c"]
DASHES = ["", "6 3", "2 2", "8 3 2 3"]
WIDTH, HEIGHT, COLUMNS = 320, 240, 3
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 26, 38
#: Errors at most this large are drawn at it.
FLOOR = 1e-16


def _points(cells, case, measure):
    """Cost (s per simulated s) and size of the error by engine and settings, in the order of costs."""
    curves = {}
    for cell in cells:
        error = cell.get(f"error_{measure}")
        if cell["scenario"] != case or cell["outcome"] != "passed" or not error or not cell["cpu_s"]:
            continue
        size, cost = abs(float(error)), float(cell["cpu_s"]) / float(cell["duration_s"])
        if math.isfinite(size) and cost > 0:
            curves.setdefault((cell["method"], cell["integrator"]), []).append((cost, max(size, FLOOR)))
    return {choice: sorted(points) for choice, points in curves.items()}


class _Axis:
    """A logarithmic axis over whole decades."""

    def __init__(self, values, start, end):
        self.first = math.floor(math.log10(min(values)) + 1e-9)
        self.last = max(self.first + 1, math.ceil(math.log10(max(values)) - 1e-9))
        self.start, self.end = start, end

    def at(self, value):
        share = (math.log10(value) - self.first) / (self.last - self.first)
        return self.start + share * (self.end - self.start)

    def decades(self):
        """Exponents with marks, at most eight."""
        every = max(1, math.ceil((self.last - self.first) / 8))
        return range(self.first, self.last + 1, every)


def _panel(curves, title, unit, styles, x0, y0):
    parts = [f'<g transform="translate({x0} {y0})">']
    parts.append(f'<text x="{LEFT}" y="16" class="title">{escape(title)}</text>')
    if not curves:
        parts.append(f'<text x="{LEFT}" y="{HEIGHT / 2}">not measured</text></g>')
        return parts
    points = [point for curve in curves.values() for point in curve]
    across = _Axis([cost for cost, _ in points], LEFT, WIDTH - RIGHT)
    up = _Axis([size for _, size in points], HEIGHT - BOTTOM, TOP)
    for exponent in across.decades():
        x = across.at(10.0**exponent)
        parts.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{HEIGHT - BOTTOM}" class="grid"/>')
        parts.append(
            f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 13}" class="mark" text-anchor="middle">1e{exponent}</text>'
        )
    for exponent in up.decades():
        y = up.at(10.0**exponent)
        parts.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{WIDTH - RIGHT}" y2="{y:.1f}" class="grid"/>')
        parts.append(
            f'<text x="{LEFT - 4}" y="{y + 3:.1f}" class="mark" text-anchor="end">1e{exponent}</text>'
        )
    middle = (LEFT + WIDTH - RIGHT) / 2
    parts.append(
        f'<text x="{middle}" y="{HEIGHT - 8}" class="mark" text-anchor="middle">'
        "processor s per simulated s</text>"
    )
    parts.append(
        f'<text transform="translate(12 {HEIGHT / 2}) rotate(-90)" class="mark" '
        f'text-anchor="middle">error, {escape(unit)}</text>'
    )
    for choice, curve in curves.items():
        colour, dash = styles[choice]
        path = " ".join(f"{across.at(cost):.1f},{up.at(size):.1f}" for cost, size in curve)
        parts.append(f'<polyline points="{path}" stroke="{colour}" stroke-dasharray="{dash}"/>')
        for cost, size in curve:
            parts.append(
                f'<circle cx="{across.at(cost):.1f}" cy="{up.at(size):.1f}" r="2.4" fill="{colour}"/>'
            )
    return [*parts, "</g>"]


def _styles(choices):
    """Colour of the engine and dash of the settings, by choice."""
    engines = list(dict.fromkeys(engine for engine, _ in choices))
    settings = {engine: [s for e, s in choices if e == engine] for engine in engines}
    return {
        (engine, setting): (
            COLOURS[engines.index(engine) % len(COLOURS)],
            DASHES[settings[engine].index(setting) % len(DASHES)],
        )
        for engine, setting in choices
    }


def svg(cells):
    """The picture of the rows of `rows.read_cells`."""
    choices = list(dict.fromkeys((cell["method"], cell["integrator"]) for cell in cells))
    # This project's own engine has the first colour.
    choices.sort(key=lambda choice: choice[0] != "stiction")
    styles = _styles(choices)
    width, lines = WIDTH * COLUMNS, math.ceil(len(PANELS) / COLUMNS)
    per_line = 5
    legend = 18 * math.ceil(len(choices) / per_line) + 10
    height = HEIGHT * lines + legend
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11">',
        "<style>.title{font-weight:bold}.mark{font-size:9px;fill:#444}.grid{stroke:#ddd}"
        "polyline{fill:none;stroke-width:1.6}</style>",
        f'<rect width="{width}" height="{height}" fill="white"/>',
    ]
    for k, (case, measure, title, unit) in enumerate(PANELS):
        x0, y0 = WIDTH * (k % COLUMNS), HEIGHT * (k // COLUMNS)
        parts += _panel(_points(cells, case, measure), title, unit, styles, x0, y0)
    for k, choice in enumerate(choices):
        x, y = LEFT + (k % per_line) * (width - LEFT) / per_line, HEIGHT * lines + 14 + 18 * (k // per_line)
        colour, dash = styles[choice]
        parts.append(
            f'<line x1="{x:.0f}" y1="{y - 4}" x2="{x + 26:.0f}" y2="{y - 4}" stroke="{colour}" '
            f'stroke-width="1.6" stroke-dasharray="{dash}"/>'
        )
        parts.append(f'<text x="{x + 32:.0f}" y="{y}">{escape(" ".join(choice))}</text>')
    return "\n".join([*parts, "</svg>", ""])


def write(folder, file):
    """Writes the picture of the results in a folder."""
    Path(file).write_text(svg(rows.read_cells(folder)))
