#!/usr/bin/env python3
"""Lists the legged models of Python packages: which ones load, and why the others are refused.

Run by hand:

    python tests/oracles/list_legged_models.py --runner target/release/runner --write docs/model-formats.md \\
        example-robot-data=.../site-packages/cmeel.prefix/share/example-robot-data/robots dm_control=FOLDER ...

Each FOLDER holds the files of a package, as pip installs them or unpacked from the wheel; the version is that of the
package's `*.dist-info` in FOLDER or above. Files are chosen by their names (LEGGED). A file is read by `runner inspect
--format json`; one that is refused and has no bodies itself is a fragment, and is left out. Without --write the table
is printed; with it, the table between the two comments of the page is replaced.
"""

import argparse
import json
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Words of the names of legged robots and animals; the whole name of a file or folder, or a part of it between _ - and /.
LEGGED = """a1 alex alexander ant anymal apollo atlas b1 barkour berkeley biped biped2d bolt cassie cheetah digit dog
    drosophila fruitfly g1 go1 go2 h1 hector hopper human humanoid humanoidstandup humanoid3d hyq icub laikago microtaur
    minitaur op3 quadruped rodent romeo simple solo solo12 spirit40 spirit40newer spot t1 talos torso vision60 walker
    walker2d myolegs myolegs22 legs""".split()
BEGIN, END = "<!-- list_legged_models.py: begin -->", "<!-- list_legged_models.py: end -->"
SECONDS = 300


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runner", default="target/release/runner")
    arguments.add_argument("--write", type=Path)
    arguments.add_argument("packages", nargs="+", metavar="PACKAGE=FOLDER")
    given = arguments.parse_args()
    rows, loaded, refused = [], 0, 0
    for package in given.packages:
        name, folder = package.split("=", 1)
        folder = Path(folder)
        files = [path for path in sorted(folder.rglob("*")) if is_legged(path, folder)]
        with ThreadPoolExecutor(2) as pool:
            results = list(pool.map(lambda path: inspect(given.runner, path), files))
        for path, (is_read, text) in zip(files, results):
            if text is None:
                continue
            loaded, refused = loaded + is_read, refused + (not is_read)
            rows.append(f"| {name} {version(name, folder)} | `{path.relative_to(folder)}` | {text} |")
    head = [f"{loaded} of {loaded + refused} models load.", "", "| package | file | result |", "|---|---|---|"]
    table = "\n".join([*head, *rows])
    if not given.write:
        print(table)
        return
    page = given.write.read_text()
    before, rest = page.split(BEGIN)
    given.write.write_text(f"{before}{BEGIN}\n\n{table}\n\n{END}{rest.split(END)[1]}")


def is_legged(path, folder):
    if path.suffix not in (".urdf", ".xml", ".mjcf", ".sdf") or not path.is_file():
        return False
    words = re.split(r"[^a-z0-9]+", str(path.relative_to(folder)).lower())
    text = re.sub(r"<!--.*?-->", "", path.read_text(errors="ignore"), flags=re.S)
    return bool(set(words) & set(LEGGED)) and re.search(r"<(robot|mujoco|sdf)[\s>]", text) is not None


def inspect(runner, path):
    """Whether the file is read, and its cell; no cell for a fragment."""
    def run(*options):
        command = [runner, "inspect", path.name, "--format", "json", *options]
        return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, cwd=path.parent)

    try:
        done = run()
        repaired = done.returncode != 0 and "inertia of" in done.stderr and run("--repair").returncode == 0
    except subprocess.TimeoutExpired:
        return False, f"no answer within {SECONDS} s"
    if done.returncode == 0:
        robot = json.loads(done.stdout)
        joints, base = len(robot["joints"]), robot["base"]
        mass = robot["mass"]
        warnings = sum(notice["severity"] == "warning" for notice in robot["notices"])
        warned = f"; warnings: {warnings}" if warnings else ""
        return True, f"loads: {base} base, {joints} joints, {mass:.5g} kg{warned}"
    has_body = re.search(r"<(body|link|model)[\s>]", path.read_text(errors="ignore")) is not None
    if not has_body and "no robot" in done.stderr:
        return False, None
    lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    message = re.sub(r"^error: ", "", lines[0]) if lines else f"exit code {done.returncode}"
    position = next((re.search(r"([^/ ]+:\d+):\d+$", line) for line in lines if line.startswith("-->")), None)
    where = f" ({position[1]})" if position else ""
    help = "; loads with `--repair`" if repaired else ""
    return False, f"refused: {message}{where}{help}".replace("|", "\\|")


def version(name, folder):
    """The version of the package that the folder belongs to."""
    same = name.replace("-", "_").lower()
    for above in [folder, *folder.parents][:6]:
        for info in above.glob("*.dist-info"):
            package, number = info.name.removesuffix(".dist-info").rsplit("-", 1)
            if package.replace("-", "_").lower() == same:
                return number
    return "?"


if __name__ == "__main__":
    main()
