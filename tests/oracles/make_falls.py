#!/usr/bin/env python3
"""Writes contact_falls.json: contact problems of falls onto links, terrain and objects, and their solutions by Pinocchio's ADMM.

Run by hand, in an environment with `pin` (4.1 or newer) and a built `runner`:

    python tests/oracles/make_falls.py target/release/runner

As make_contact.py, whose text explains which problems are comparable and when their wrenches are unique; here the polygons are
those of links on the floor and of pairs of bodies, each in its own axes.
"""

import collections
import json
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from make_contact import HERE, ROBOTS, TIGHT, Left, Vertices, numbers, semi, solve

# Greatest number of problems of a run, of those with the same pattern of states, and of polygons.
PER_RUN, PER_KIND, POLYGONS = 6, 1, 9

RUBBLE = f'[[terrain]]\ntype = "heightfield"\nfile = "{ROBOTS.parent / "scenarios/terrain/rubble.csv"}"\nsize = [6, 6]\n'


def fall(robot, height, rpy, velocity, more=""):
    base = f"position = [0, 0, {height}], rpy = {rpy}, linear_velocity = {velocity}"
    return f'robot = {{ model = "{ROBOTS / robot / robot}.toml", contact = "bodies", base = {{ {base} }} }}\n{more}'


def boxes(*boxes):
    head = f'robot = {{ model = "{ROBOTS / "ground/ground"}.urdf" }}\n'
    entry = '[[object]]\ntype = "box"\nsize = {}\nmass = {}\nposition = {}\nrpy = {}\nlinear_velocity = {}\n'
    return head, "".join(entry.format(*box) for box in boxes)


TOWER = boxes(
    ([0.2, 0.2, 0.1], 1.0, [0, 0, 0.05], [0, 0, 0], [0, 0, 0]),
    ([0.2, 0.2, 0.1], 2.0, [0.02, 0.01, 0.15], [0, 0, 0.3], [0, 0, 0]),
    ([0.3, 0.1, 0.1], 1.5, [0.03, 0.02, 0.28], [0.2, 0.1, 0], [0.5, 0.2, 0]),
)
# (run, duration, friction, top level, tables)
RUNS = [
    ("hoap2", 1.2, 0.5, fall("hoap2", 0.6, [0.3, 1.1, 0.2], [0.5, 0.2, 0]), ""),
    ("hoap2-steps", 1.0, 0.4, fall("hoap2", 0.5, [1.2, 0.2, 0.4], [0.4, 0.1, 0]) + semi(2e-3), ""),
    ("hoap2-rubble", 1.0, 0.6, fall("hoap2", 0.6, [-0.4, 1.0, 0.5], [0.3, 0.2, 0]), RUBBLE),
    ("hoap2-rubble-steps", 0.8, 0.6, fall("hoap2", 0.55, [0.8, -0.9, 0.1], [0.2, 0.5, 0]) + semi(2e-3), RUBBLE),
    ("cbi", 1.6, 0.5, fall("cbi", 1.3, [-0.5, 0.9, 0.3], [0.5, 0, 0]), ""),
    ("quadruped-rubble", 1.2, 0.7, fall("quadruped", 0.8, [0.7, 0.5, 0.1], [0.6, 0.3, 0]), RUBBLE),
    ("tower", 0.8, 0.4, *TOWER),
    ("tower-steps", 0.6, 0.4, TOWER[0] + semi(4e-3), TOWER[1]),
]


def problems(runner, folder):
    """Selections of all runs: (run, number, selection), in order."""
    for name, duration, friction, top, tables in RUNS:
        path = folder / f"{name}.toml"
        head = f"duration = {duration}\nfloor = {{ friction = {friction} }}\nlog = {{ rate = 0.0 }}\n"
        path.write_text(head + top + TIGHT + tables)
        command = [runner, path, "-o", folder / "results", "--dump-problems=all"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        for file in sorted((folder / "results" / path.stem).glob("*/problems/*.json")):
            problem = json.loads(file.read_text())
            yield name, problem["number"], problem["selection"]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    random = np.random.default_rng(1)
    entries, left = [], collections.Counter()
    taken, kinds, met = collections.Counter(), collections.Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        for name, number, selection in problems(Path(sys.argv[1]).resolve(), Path(folder)):
            met += 1
            states = tuple(sorted(s.rstrip("0123456789") for s in selection["answer"]["states"] if s != "free"))
            kind = (name, selection["level"], states)
            if not selection["answer"]["consistent"]:
                left["no valid state found by this program"] += 1
                continue
            if len(selection["soles"]) > POLYGONS:
                left[f"more than {POLYGONS} polygons"] += 1
                continue
            if len(states) < 2 or taken[name] >= PER_RUN or kinds[kind] >= PER_KIND:
                left["one contact, or enough of that kind"] += 1
                continue
            try:
                wrench, residual, iterations = solve(Vertices(selection), random)
            except Left as why:
                left[str(why)] += 1
                continue
            taken[name] += 1
            kinds[kind] += 1
            entries.append(
                {
                    "run": name,
                    "number": number,
                    "iterations": iterations,
                    "residual": residual,
                    "wrench": wrench,
                    "selection": selection,
                }
            )
            ours = np.array(selection["answer"]["wrench"])
            miss = np.abs(wrench - ours).max() / np.abs(wrench).max() if wrench.any() else np.abs(ours).max()
            print(f"{name} {number:4} {selection['level'][:3]} {miss:.1e} {iterations:5} {' '.join(states)}", flush=True)
    versions = {"pin": pin.__version__, "numpy": np.__version__, "python": platform.python_version()}
    head = f'"robot":"falls",\n"versions":{json.dumps(versions)},\n"problems":[\n'
    body = ",\n".join(json.dumps(numbers(e), separators=(",", ":")) for e in entries)
    path = HERE / "contact_falls.json"
    path.write_text("{" + head + body + "\n]}\n")
    print(f"{path.name}: {len(entries)} problems, {path.stat().st_size} bytes")
    print(f"{met} problems met, left out:", dict(left))


if __name__ == "__main__":
    main()
