"""Hard pushes, tilted landings and slopes for the robots of the Python package `example-robot-data`,
with a table of outcomes, costs and residuals.

    python3 scenarios/studies/hard_pushes.py RUNNER --robots .../example-robot-data/robots
    python3 scenarios/studies/hard_pushes.py --table results/summary.csv

The first writes one scenario per case, runs them as one batch and prints the table. The second
prints the table of an existing summary, also of scenarios/studies/hard-pushes.toml.

Posture: `half_sitting` or `standing` of the robot's SRDF, G1 with slightly bent knees. Joints
without a value are at 0.

Gains: legs kp = 2.5 m g h, with the mass m and the height h of the centre of mass in the posture.
kd = 0.03 s kp and armature = 5e-5 s^2 kp. All other joints have 0.3 of these values. Efforts are
unlimited, and joints have no friction and no stops.

Cases, in turn; each has a friction of 0.1 to 1:

- `push`: on a level floor; a half-sine at 0.2 s on the torso, 0.1 to 0.8 times the weight, 20 to
  300 ms, in any direction;
- `landing`: tilted by up to 0.4 rad after a fall from up to 5 cm;
- `slope`: up to 25 degrees, and a push as above.

A run ends as fallen with the base below half the height of the centre of mass. Only the soles touch
the floor.

A scenario places the lowest vertex on the floor, so a landing begins at the speed of its fall. The
draws of a case depend on `--seed`, the robot and the number of the case only.

A run is not done if it did not end by itself, or took more processor time than `--timeout-factor`
times the simulated time. Needs Python 3.9, nothing else.
"""

import argparse
import csv
import json
import math
import random
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
from collections import Counter
from pathlib import Path

GRAVITY = 9.81  # m/s^2
DURATION = 2.0  # s

# Folder and files of a robot, mass (kg), height of the centre of mass in the posture (m), pushed
# link, pattern of the names of leg joints.
ROBOTS = {
    "g1": {
        "urdf": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        # The package has no SRDF of this robot.
        "posture": {
            f"{side}_{joint}_joint": value
            for side in ("left", "right")
            for joint, value in (("hip_pitch", -0.1), ("knee", 0.3), ("ankle_pitch", -0.2))
        },
        "mass": 33.3411,
        "height": 0.697004,
        "link": "torso_link",
        "legs": r"hip|knee|ankle",
    },
    "talos": {
        "urdf": "talos_data/robots/talos_reduced.urdf",
        "srdf": "talos_data/srdf/talos.srdf",
        "state": "half_sitting",
        "mass": 90.2722,
        "height": 0.877111,
        "link": "torso_2_link",
        "legs": r"^leg_",
    },
    "romeo": {
        "urdf": "romeo_description/urdf/romeo_small.urdf",
        "srdf": "romeo_description/srdf/romeo_small.srdf",
        "state": "half_sitting",
        "mass": 40.5294,
        "height": 0.66172,
        "link": "torso",
        "legs": r"Hip|Knee|Ankle",
    },
    "simple_humanoid": {
        "urdf": "simple_humanoid_description/urdf/simple_humanoid.urdf",
        "srdf": "simple_humanoid_description/srdf/simple_humanoid.srdf",
        "state": "half_sitting",
        "mass": 130.8,
        "height": 0.753732,
        "link": "torso",
        "legs": r"LEG_",
        # The URDF has no feet. Their size is in the SRDF: 0.25 x 0.14 m, 0.105 m below the ankle.
        "soles": {"left": "l_ankle", "right": "r_ankle"},
        "polygon": [[0.125, 0.07, -0.105], [-0.125, 0.07, -0.105], [-0.125, -0.07, -0.105], [0.125, -0.07, -0.105]],
    },
    "solo12": {
        "urdf": "solo_description/robots/solo12.urdf",
        "srdf": "solo_description/srdf/solo.srdf",
        "state": "standing",
        "mass": 2.5,
        "height": 0.207988,
        "link": "base_link",
        "legs": r"",
    },
    "anymal": {
        "urdf": "anymal_b_simple_description/robots/anymal.urdf",
        "srdf": "anymal_b_simple_description/srdf/anymal.srdf",
        "state": "standing",
        "mass": 30.4754,
        "height": 0.465194,
        "link": "base",
        "legs": r"",
    },
}

# Masses of the robots of hard-pushes.toml, kg.
OWN = {"hoap2": 7.12, "cbi": 62.88, "quadruped": 13.38}

CASES = ("push", "landing", "slope")

METHODS = """
[[sweep.zip]]
"contact.method" = ["exact", "exact", "one-step"]
"integrator.method" = ["dopri5", "semi-implicit", "semi-implicit"]
"""


def posture(robot, folder):
    """Positions of all moving joints by name."""
    joints = xml.parse(folder / robot["urdf"]).getroot().findall("joint")
    values = {joint.get("name"): 0.0 for joint in joints if joint.get("type") in ("revolute", "continuous", "prismatic")}
    given = robot.get("posture", {})
    if "srdf" in robot:
        states = xml.parse(folder / robot["srdf"]).getroot().findall("group_state")
        state = next(state for state in states if state.get("name") == robot["state"])
        # The root joint has seven values.
        given = {joint.get("name"): float(joint.get("value")) for joint in state.findall("joint") if " " not in joint.get("value").strip()}
    values.update((name, value) for name, value in given.items() if name in values)
    return values


def drive(robot, joint):
    kp = 2.5 * robot["mass"] * GRAVITY * robot["height"]
    if not re.search(robot["legs"], joint):
        kp *= 0.3
    return f'{{ mode = "position", kp = {kp!r}, kd = {0.03 * kp!r}, armature = {5e-5 * kp!r}, effort = 1e6, friction = {{ coulomb = 0.0, viscous = 0.0 }} }}'


def unit_vector(draw):
    z = draw.uniform(-1.0, 1.0)
    angle = draw.uniform(0.0, 2.0 * math.pi)
    across = math.sqrt(1.0 - z * z)
    return [across * math.cos(angle), across * math.sin(angle), z]


def tilt(draw, limit):
    """Roll, pitch and yaw that tilt the vertical by up to `limit` in a random direction."""
    angle = draw.uniform(0.0, limit)
    direction = draw.uniform(0.0, 2.0 * math.pi)
    x = math.sin(angle) * math.cos(direction)
    y = math.sin(angle) * math.sin(direction)
    return [-math.asin(y), math.atan2(x, math.cos(angle)), 0.0]


def scenario(name, robot, folder, seed, number):
    """Kind and text of a case."""
    draw = random.Random(f"{seed} {name} {number}")
    case = CASES[number % len(CASES)]
    friction = draw.uniform(0.1, 1.0)
    base, floor = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    velocity = 0.0
    if case == "landing":
        base = tilt(draw, 0.4)
        velocity = -math.sqrt(2.0 * GRAVITY * draw.uniform(0.0, 0.05))
    elif case == "slope":
        base = floor = tilt(draw, math.radians(25.0))

    values = posture(robot, folder)
    lines = [
        f"# Case {number} of {name}, seed {seed}; written by hard_pushes.py.",
        f"duration = {DURATION}",
        f"seed = {seed}",
        "",
        "[robot]",
        f"model = {json.dumps(str((folder / robot['urdf']).resolve()))}",
        'inertia = "repair"',
        'joint_limits = "ignore"',
        f"base = {{ rpy = {base}, linear_velocity = [0.0, 0.0, {velocity}] }}",
        "",
        "[robot.posture]",
        *(f"{json.dumps(joint)} = {value}" for joint, value in values.items()),
        "",
        "[robot.joint]",
        *(f"{json.dumps(joint)} = {drive(robot, joint)}" for joint in values),
        "",
    ]
    for sole, link in robot.get("soles", {}).items():
        lines += ["[[robot.soles]]", f'name = "{sole}"', f'link = "{link}"', f"polygon = {robot['polygon']}", ""]
    lines += [
        "[floor]",
        f"friction = {friction}",
        f"rpy = {floor}",
        "",
        "[contact]",
        "velocity_tolerance = 0.02",
        "",
        "[integrator]",
        "step = 1e-3",
        "",
        "[control]",
        "rate = 500",
        "",
        "[log]",
        "rate = 0",
        "",
        "[stop]",
        f"fallen = {{ below = {0.5 * robot['height']} }}",
        "",
    ]
    if case != "landing":
        peak = draw.uniform(0.1, 0.8) * robot["mass"] * GRAVITY
        lines += [
            "[[force]]",
            'type = "push"',
            f'link = "{robot["link"]}"',
            f"force = {[peak * component for component in unit_vector(draw)]}",
            "start = 0.2",
            f"duration = {draw.uniform(0.02, 0.3)}",
            'profile = "half-sine"',
            "",
        ]
    return case, "\n".join(lines) + METHODS


def number(row, column):
    return float(row[column]) if row.get(column) else 0.0


def quantile(values, fraction):
    """Least value that is not below the given fraction of all."""
    return sorted(values)[max(0, math.ceil(fraction * len(values)) - 1)]


def short(value):
    return f"{value:.2g}" if abs(value) < 99.5 else f"{value:.0f}"


def robot_of(row):
    """Name of the robot of a run, of this script or of hard-pushes.toml; otherwise nothing."""
    if row["scenario"] == "hard-pushes":
        return Path(row.get("robot.model") or "hoap2.toml").stem
    return row["scenario"].split("-")[0]


def table(rows, factor):
    """Markdown table with one line per robot, method and integrator."""
    masses = {**OWN, **{name: robot["mass"] for name, robot in ROBOTS.items()}}
    groups = {}
    for row in rows:
        if robot_of(row) in masses:
            groups.setdefault((robot_of(row), row["method"], row["integrator"]), []).append(row)
    head = [
        "robot", "method", "runs", "outcomes", "not done", "inconsistent", "cost, s/s", "candidates",
        "cone excess, weights", "energy error, J", "steps",
    ]  # fmt: skip
    lines = [head, ["---"] * len(head)]
    for (name, method, integrator), runs in groups.items():
        outcomes = Counter(run["outcome"] for run in runs)
        costs = [number(run, "cpu_s") / max(number(run, "duration_s"), 1e-9) for run in runs]
        not_done = sum(
            run["outcome"] not in ("passed", "failed", "fallen") or cost > factor for run, cost in zip(runs, costs)
        )
        inconsistent = [int(number(run, "inconsistent")) for run in runs]
        steps = [int(number(run, "steps")) for run in runs]
        # Runs count by their steps: the summary has no number of selections.
        tested = sum(number(run, "states_tested_mean") * count for run, count in zip(runs, steps)) / max(1, sum(steps))
        excess = max(number(run, "max_cone_excess") for run in runs) / (masses[name] * GRAVITY)
        lines.append([
            name,
            f"{method}, {integrator}",
            str(len(runs)),
            ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common()),
            str(not_done),
            f"{sum(inconsistent)} in {sum(count > 0 for count in inconsistent)}",
            ", ".join(short(cost) for cost in (quantile(costs, 0.5), quantile(costs, 0.9), max(costs))),
            f"{tested:.1f}, {max(int(number(run, 'states_tested_max')) for run in runs)}",
            f"{excess:.1g}",
            f"{max(abs(number(run, 'energy_error_J')) for run in runs):.1g}",
            f"{int(quantile(steps, 0.5))}, {max(steps)}",
        ])  # fmt: skip
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


NOTES = """
- not done: stopped by a limit, or more than {factor:g} s of processor time per simulated s
- inconsistent: selections without a valid state, in how many runs
- cost: processor time per simulated time: median, 90 %, worst
- candidates per selection: mean, worst
- cone excess and energy error: worst
- steps of a run: median, worst
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runner", nargs="?", metavar="RUNNER", help="the program")
    parser.add_argument("--robots", type=Path, metavar="DIR", help="folder `robots` of example-robot-data")
    parser.add_argument("--runs", type=int, default=20, metavar="N", help="cases per robot (default: 20)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="seed of all draws (default: 1)")
    parser.add_argument("--only", action="append", choices=ROBOTS, metavar="NAME", help="this robot; may be repeated")
    parser.add_argument("--output", type=Path, default=Path("results/hard-pushes"), metavar="DIR", help="folder of scenarios and results")
    parser.add_argument("--timeout-factor", type=float, default=5.0, metavar="F", help="limit of processor time per simulated time (default: 5)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="parallel runs (default: 1)")
    parser.add_argument("--table", type=Path, metavar="CSV", help="only print the table of this summary")
    options = parser.parse_args()

    summary = options.table
    if summary is None:
        if options.runner is None or options.robots is None:
            parser.error("RUNNER and --robots are required without --table")
        folder = options.output / "scenarios"
        folder.mkdir(parents=True, exist_ok=True)
        files = []
        for name in options.only or ROBOTS:
            for index in range(options.runs):
                case, text = scenario(name, ROBOTS[name], options.robots, options.seed, index)
                files.append(folder / f"{name}-{index:03}-{case}.toml")
                files[-1].write_text(text)
        # The limit is wall-clock time, twice the processor time allowed.
        limit = 2.0 * options.timeout_factor * DURATION
        command = [options.runner, *map(str, files), "--output", str(options.output), "--jobs", str(options.jobs)]
        command += ["--no-log", "--no-timing", "--timeout", f"{limit:g}"]
        # Exit code 3: a run did not finish; the table counts these.
        code = subprocess.run(command, stdout=sys.stderr).returncode
        if code not in (0, 3):
            sys.exit(f"error: {options.runner} ended with exit code {code}")
        summary = options.output / "summary.csv"

    with open(summary, newline="") as file:
        print(table(list(csv.DictReader(file)), options.timeout_factor))
    print(NOTES.format(factor=options.timeout_factor), end="")


if __name__ == "__main__":
    main()
