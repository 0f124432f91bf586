"""Processor time of a fixed step over the number of boxes that rest on the floor, apart or in a stack.

    python3 scenarios/studies/growth.py RUNNER [--picture docs/pictures/growth.svg]

Writes one scenario per number and arrangement, runs them one after the other, and prints the time per
step of 1 ms of each contact method as a table: half a second less a tenth of one, over the steps
between, the least of three. Boxes in a stack are moved by 1 cm against the one below. Needs Python 3.9,
nothing else.
"""

import argparse
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COUNTS = (1, 2, 4, 8, 16, 32, 64)
METHODS = ("exact", "one-step", "ncp")
ARRANGEMENTS = ("apart", "stack")
ENDS = (0.1, 0.5)  # s
STEP = 1e-3  # s


def scenario(arrangement, count, method, end):
    text = f"""duration = {end}
robot = {{ model = "{ROOT}/robots/ground/ground.urdf" }}
contact = {{ method = "{method}" }}
integrator = {{ method = "semi-implicit", step = {STEP} }}
log = {{ rate = 0 }}
"""
    for i in range(count):
        apart = (0.3 * (i % 8), 0.3 * (i // 8), 0.05)
        stack = (0.01 * (i % 2), 0, 0.05 + 0.1 * i)
        position = list(apart if arrangement == "apart" else stack)
        text += f'[[object]]\ntype = "box"\nsize = [0.2, 0.2, 0.1]\nmass = 1.0\nposition = {position}\n'
    return text


def measure(runner):
    """Microseconds per step by arrangement, method and count."""
    least = {}
    with tempfile.TemporaryDirectory() as folder:
        names = {}
        for arrangement in ARRANGEMENTS:
            for method in METHODS:
                for count in COUNTS:
                    for end in ENDS:
                        path = Path(folder, f"{arrangement}-{method}-{count}-{ENDS.index(end)}.toml")
                        path.write_text(scenario(arrangement, count, method, end))
                        names[path.stem] = (arrangement, method, count, end)
        for _ in range(3):
            output = Path(folder, "results")
            files = [str(Path(folder, f"{name}.toml")) for name in names]
            run = [runner, "run", *files, "--no-log", "-j", "1", "--output", str(output)]
            if subprocess.run(run, capture_output=True).returncode != 0:
                sys.exit("a run has failed: " + " ".join(run))
            with open(output / "summary.csv", newline="") as rows:
                for row in csv.DictReader(rows):
                    key = names[row["scenario"].split("/")[-1].removesuffix(".toml")]
                    least[key] = min(least.get(key, math.inf), float(row["cpu_s"]))
    steps = (ENDS[1] - ENDS[0]) / STEP
    return {key[:3]: (least[key] - least[(*key[:3], ENDS[0])]) / steps * 1e6 for key in least if key[3] == ENDS[1]}


def table(times):
    columns = [(a, m) for a in ARRANGEMENTS for m in METHODS]
    print("| boxes | " + " | ".join(f"{m}, {a}" for a, m in columns) + " |")
    print("|---" * (1 + len(columns)) + "|")
    for count in COUNTS:
        print(f"| {count} | " + " | ".join(f"{times[(a, m, count)]:.3g}" for a, m in columns) + " |")


def picture(times):
    """Time per step over the number of boxes on logarithmic axes, as SVG."""
    width, height, left, top, right, bottom = 640, 400, 64, 16, 150, 48
    low, high = math.floor(math.log10(min(times.values()))), math.ceil(math.log10(max(times.values())))
    x = lambda count: left + (width - left - right) * math.log2(count) / math.log2(COUNTS[-1])
    y = lambda time: top + (height - top - bottom) * (high - math.log10(time)) / (high - low)
    colours = {"exact": "#0B62A4", "one-step": "#D55E00", "ncp": "#8A6A00"}
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">']
    out.append(f'<rect width="{width}" height="{height}" fill="white"/>')
    for power in range(low, high + 1):
        at = y(10**power)
        out.append(f'<line x1="{left}" y1="{at:.1f}" x2="{width - right}" y2="{at:.1f}" stroke="#ddd"/>')
        label = f"{10**power:g}" if power >= 0 else f"{10**power:.{-power}f}"
        out.append(f'<text x="{left - 8}" y="{at + 4:.1f}" text-anchor="end">{label}</text>')
    for count in COUNTS:
        out.append(f'<text x="{x(count):.1f}" y="{height - bottom + 18}" text-anchor="middle">{count}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 8}" text-anchor="middle">boxes</text>')
    middle = (top + height - bottom) / 2
    out.append(f'<text x="14" y="{middle}" text-anchor="middle" transform="rotate(-90 14 {middle})">us per step</text>')
    ends = []
    for arrangement in ARRANGEMENTS:
        for method in METHODS:
            points = [(x(count), y(times[(arrangement, method, count)])) for count in COUNTS]
            dash = ' stroke-dasharray="6 4"' if arrangement == "stack" else ""
            line = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
            out.append(f'<polyline points="{line}" fill="none" stroke="{colours[method]}" stroke-width="2"{dash}/>')
            ends.append([points[-1][1], f"{method}, {arrangement}", colours[method]])
    # Labels at the ends of the curves, apart from each other.
    ends.sort()
    for i in range(1, len(ends)):
        ends[i][0] = max(ends[i][0], ends[i - 1][0] + 15)
    for at, label, colour in ends:
        out.append(f'<text x="{width - right + 8}" y="{at + 4:.1f}" fill="{colour}">{label}</text>')
    # Slope of growth in proportion, from one box.
    start = times[("apart", "exact", 1)]
    a, b = (x(1), y(start)), (x(COUNTS[-1]), y(start * COUNTS[-1]))
    out.append(f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" stroke="#888" stroke-dasharray="2 3"/>')
    return "\n".join(out) + "\n</svg>\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("runner")
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    times = measure(str(Path(arguments.runner).resolve()))
    table(times)
    if arguments.picture:
        arguments.picture.write_text(picture(times))


if __name__ == "__main__":
    main()
