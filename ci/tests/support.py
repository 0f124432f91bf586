"""Helps the tests: a folder of work, the environment that GitHub gives to a step, the program."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUNNER = str((ROOT / os.environ.get("STICTION_RUNNER", "target/release/runner")).resolve())


def skip(reason):
    """Prints that a test is skipped, and skips it."""
    print(f"skipped: {reason}", file=sys.stderr)
    raise unittest.SkipTest(reason)


def need_program(name):
    if shutil.which(name) is None:
        skip(f"{name} is not installed")


def scenario(friction=0.5, stop=0.40774719673802245):
    """A block that slides at 2 m/s, and where it must stop: with friction 0.5 at 4 / 9.81 m."""
    return f"""duration = 1.0
robot = {{ model = {str(ROOT / "robots/block/block.toml")!r}, base = {{ linear_velocity = [2, 0, 0] }} }}
floor = {{ friction = {friction} }}
expect = [
    {{ metric = "final_base_x", value = {stop}, tolerance = 1e-9 }},
    {{ metric = "final_base_z", value = 0.05, tolerance = 1e-9 }},
]
"""


class Step:
    """What a step of a job leaves."""

    def __init__(self, process, outputs, summary):
        self.code = process.returncode
        self.stdout = process.stdout
        self.stderr = process.stderr
        self.outputs = outputs
        self.summary = summary


class Case(unittest.TestCase):
    """A test in a folder of its own, whose name has a blank."""

    @classmethod
    def setUpClass(cls):
        need_program("bash")
        if not os.access(RUNNER, os.X_OK):
            skip(f"tests of the scripts: there is no program {RUNNER} (STICTION_RUNNER)")

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="work "))
        self.addCleanup(shutil.rmtree, self.folder)
        self.work = self.folder / "checkout"
        self.work.mkdir()

    def write(self, name, text):
        path = self.work / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def environment(self, github, given):
        kept = {key: os.environ[key] for key in ("PATH", "HOME", "TMPDIR", "SYSTEMROOT") if key in os.environ}
        environment = {**kept, "STICTION_RUNNER": RUNNER, "PYTHON": sys.executable}
        if github:
            for name in ("output", "summary"):
                (self.folder / name).write_text("", encoding="utf-8")
            environment["GITHUB_ACTIONS"] = "true"
            environment["GITHUB_OUTPUT"] = str(self.folder / "output")
            environment["GITHUB_STEP_SUMMARY"] = str(self.folder / "summary")
            environment["RUNNER_TEMP"] = str(self.folder)
        environment.update({f"STICTION_{key.upper()}": value for key, value in given.items() if value is not None})
        return environment

    def step(self, script, github=True, **given):
        """Runs a script of `ci/` as a step."""
        return self.execute(["bash", str(ROOT / "ci" / script)], self.environment(github, given), github)

    def execute(self, command, environment, github=True):
        process = subprocess.run(
            command,
            cwd=self.work,
            env=environment,
            capture_output=True,
            encoding="utf-8",
            timeout=300,
        )
        outputs, summary = {}, ""
        if github:
            # As GitHub reads it: a line without `=` is an error.
            lines = (self.folder / "output").read_text(encoding="utf-8").splitlines()
            outputs = dict(line.split("=", 1) for line in lines)
            self.assertEqual(len(outputs), len(lines), "an output is written twice")
            summary = (self.folder / "summary").read_text(encoding="utf-8")
        return Step(process, outputs, summary)

    def run_step(self, scenarios="*.toml", arguments="--no-timing", **given):
        return self.step("run.sh", scenarios=scenarios, arguments=arguments, **given)

    def files(self):
        """Names in the folder of work, all but the results."""
        return sorted(path.name for path in self.work.iterdir() if path.name != "results")


def cells(summary, first):
    """The cells of the rows whose first cell is `first`."""
    lines = [line for line in summary.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [row for row in rows if row[0] == first]
