"""Times dynamics and steps of this repository beside those of Pinocchio and MuJoCo, on the same robots and one core.

    pip install -r benches/peers/requirements.txt
    python3 benches/peers/measure.py [--rounds N] [--output TABLE.md]

Needs Python 3.11 or newer. Builds and runs the bench `budget`, compiles dynamics.cpp (g++) against the headers of the
packages, and steps MuJoCo by its own loop. All are timed in turn, round by round, so that a change of the machine's
speed meets each. Writes Markdown. What is not installed is skipped, and its row says so.
"""

import argparse
import importlib.metadata
import importlib.util
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ALGORITHMS = {
    "rnea": "inverse dynamics (RNEA)",
    "aba": "forward dynamics (ABA)",
    "crba_and_factor": "mass matrix and its Cholesky factor",
}
UNITS = {"ns": 1e-3, "µs": 1.0, "ms": 1e3, "s": 1e6}


def package_folder(package):
    """Folder of the packages' common prefix, which holds headers, libraries and robots."""
    try:
        files = importlib.metadata.files(package) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    inside = [Path(file.locate()) for file in files if "cmeel.prefix" in file.parts]
    return next((path for path in inside[0].parents if path.name == "cmeel.prefix"), None) if inside else None


def version(package):
    try:
        return f"{package} {importlib.metadata.version(package)}"
    except importlib.metadata.PackageNotFoundError:
        return f"{package}: not installed"


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if os.path.exists("/proc/cpuinfo") else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]}, {len(names)} processors" if names else platform.processor()


class Times:
    """Minimum and medians of each figure, us, over all rounds."""

    def __init__(self):
        self.seen = {}

    def add(self, key, minimum, median):
        self.seen.setdefault(key, []).append((minimum, median))

    def least(self, key):
        return min(minimum for minimum, _ in self.seen[key])

    def median(self, key):
        return statistics.median(median for _, median in self.seen[key])

    def cell(self, key):
        return f"{self.least(key):.2f} ({self.median(key):.2f})" if key in self.seen else "skipped: not installed"

    def ratio(self, key, ours):
        """Of minima."""
        return f"{self.least(key) / self.least(ours):.2f}" if key in self.seen and ours in self.seen else "-"


def bench(robots):
    """Path of the compiled bench and the environment that it needs."""
    command = ["cargo", "bench", "--bench", "budget", "--profile", "release", "--locked", "--no-run",
               "--message-format", "json"]
    output = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
    artifacts = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    paths = [a["executable"] for a in artifacts if a.get("target", {}).get("name") == "budget" and a.get("executable")]
    environment = dict(os.environ)
    if robots:
        environment["EXAMPLE_ROBOT_DATA"] = str(robots)
    return paths[-1], environment


def add_ours(times, program, environment, filters):
    """Reads the tree that divan prints: `|- name  fastest | slowest | median | mean | ...`."""
    command = [program, "--bench", *filters, "--sample-count", "1000", "--color", "never"]
    output = subprocess.run(command, cwd=ROOT, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout
    path = []
    for line in output.splitlines():
        match = re.match(r"([│├╰─ ]+)(\S[^│]*?)(?: {2,}|$)(.*)", line)
        if not match:
            continue
        name, rest = match[2], match[3]
        path = path[: len(match[1]) // 3 - 1]
        time = re.search(r" ([\d.]+) (ns|µs|ms|s)$", match[2])
        fastest = re.match(r"([\d.]+) (ns|µs|ms|s)", rest)
        if time and not fastest:
            name, fastest = name[: time.start()].strip(), time
        path.append(name)
        cells = [cell.strip() for cell in line.split("│")]
        values = [re.fullmatch(r"([\d.]+) (ns|µs|ms|s)", cell) for cell in cells]
        values = [float(value[1]) * UNITS[value[2]] for value in values if value]
        if fastest and len(values) >= 3:
            # Slowest, median and mean; the fastest shares its cell with the name.
            times.add(("ours", *path[-2:]), float(fastest[1]) * UNITS[fastest[2]], values[1])


def compile_dynamics(folder):
    """Path of the program that times Pinocchio, or why there is none."""
    prefix = package_folder("libpinocchio")
    if prefix is None:
        return None, "skipped: not installed"
    if not (prefix / "include/eigen3").is_dir() or not (prefix / "include/urdfdom_headers").is_dir():
        return None, "skipped: headers of Eigen or urdfdom not installed"
    if shutil.which("g++") is None:
        return None, "skipped: no g++"
    program = Path(folder) / "dynamics"
    includes = [f"-isystem{prefix / 'include' / name}" for name in ("", "eigen3", "urdfdom_headers")]
    # Limits of Boost as in the package's own CMake files.
    limits = ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
              "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "-DBOOST_FUSION_INVOKE_MAX_ARITY=12"]
    libraries = [f"-L{prefix / 'lib'}", f"-Wl,-rpath,{prefix / 'lib'}", "-lpinocchio_parsers", "-lpinocchio_default",
                 "-lboost_serialization"]
    command = ["g++", "-std=c++17", "-O3", "-DNDEBUG", *limits, *includes, str(HERE / "dynamics.cpp"), "-o",
               str(program), *libraries]
    if subprocess.run(command).returncode:
        return None, "skipped: does not compile"
    return program, None


def add_pinocchio(times, program, paths):
    command = [program, *(f"{name}={path}" for name, path in paths.items()), "--samples", "100"]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    found = {}
    for line in output.splitlines():
        if not line.startswith("#"):
            robot, name, minimum, median = line.split()
            found.setdefault((robot, name.split("-")[0]), []).append((float(minimum), float(median)))
    for (robot, name), both in found.items():
        # Of its two conventions the faster one.
        times.add(("pinocchio", name, robot), *min(both))


def dynamics_table(times, robots, reason):
    lines = ["| robot | algorithm | stiction | Pinocchio | ratio |", "|---|---|---|---|---|"]
    for robot in robots:
        for key, title in ALGORITHMS.items():
            ours, theirs = ("ours", key, robot), ("pinocchio", key, robot)
            cell = reason or times.cell(theirs)
            lines.append(f"| {robot} | {title} | {times.cell(ours)} | {cell} | {times.ratio(theirs, ours)} |")
    return lines


def step_table(times, robots, has_mujoco):
    methods = ["one-step", "exact"]
    lines = ["| robot | `one-step` | `exact` | MuJoCo, pyramidal cone | MuJoCo, elliptic cone | ratio to `one-step` | "
             "ratio to `exact` |", "|---|---|---|---|---|---|---|"]
    for robot in robots:
        ours = [("ours", "standing_step", f"{robot} {method}") for method in methods]
        theirs = [("mujoco", cone, robot) for cone in ("pyramidal", "elliptic")]
        cells = [times.cell(key) for key in ours + theirs]
        ratios = ["-", "-"]
        if has_mujoco:
            fastest = min(theirs, key=times.least)
            ratios = [times.ratio(fastest, key) for key in ours]
        lines.append(f"| {robot} | {' | '.join(cells + ratios)} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--output", type=Path)
    arguments = parser.parse_args()
    package = package_folder("example-robot-data")
    given = os.environ.get("EXAMPLE_ROBOT_DATA")
    data = Path(given) if given else package and package / "share/example-robot-data"
    with open(HERE.parent / "standing.toml", "rb") as file:
        robots = {robot["name"]: robot for robot in tomllib.load(file)["robot"]}
    folders = [ROOT / "robots", *([data / "robots", data] if data else [])]
    paths = {name: next((f / robot["file"] for f in folders if (f / robot["file"]).is_file()), None)
             for name, robot in robots.items()}
    paths = {name: path for name, path in paths.items() if path}
    times, standing = Times(), {}
    if has_mujoco := importlib.util.find_spec("mujoco") is not None:
        import mujoco_step

        for name, path in paths.items():
            for cone in ("pyramidal", "elliptic"):
                standing[name, cone] = mujoco_step.Standing(robots[name], path, cone == "elliptic")
    program, environment = bench(data)
    with tempfile.TemporaryDirectory() as folder:
        pinocchio, reason = compile_dynamics(folder)
        for number in range(arguments.rounds):
            print(f"round {number + 1} of {arguments.rounds}", file=sys.stderr)
            add_ours(times, program, environment, ["dynamics::rnea", "dynamics::aba", "dynamics::crba"])
            if pinocchio:
                add_pinocchio(times, pinocchio, paths)
            add_ours(times, program, environment, ["standing_step"])
            for (name, cone), robot in standing.items():
                samples = robot.sample(100)
                times.add(("mujoco", cone, name), min(samples), statistics.median(samples))
    skipped = [f"{name}: skipped: example-robot-data is not installed" for name in robots if name not in paths]
    lines = [
        f"{processor()}. {', '.join(map(version, ['pin', 'mujoco', 'example-robot-data']))}. us, one core: minimum "
        f"(median) of {arguments.rounds} rounds in turn; ratios of the minima, theirs to ours.",
        *skipped, "", *dynamics_table(times, paths, reason), "", *step_table(times, paths, has_mujoco),
    ]
    text = "\n".join(lines) + "\n"
    print(text, end="")
    if arguments.output:
        arguments.output.write_text(text)


if __name__ == "__main__":
    main()
