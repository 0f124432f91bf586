"""Helps the tests: finds the package, skips what is not installed, compares results."""

import csv
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from contextlib import contextmanager
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
PACKAGE = REPOSITORY / "python" / "stiction"

# The module that was built in the tree precedes an installed package.
if list(PACKAGE.glob("_native*.so")) + list(PACKAGE.glob("_native*.pyd")):
    sys.path.insert(0, str(PACKAGE.parent))


def skip(reason):
    """Prints that a test is skipped, and skips it."""
    print(f"skipped: {reason}", file=sys.stderr)
    raise unittest.SkipTest(reason)


def need(module, what):
    """Skips without a module."""
    if importlib.util.find_spec(module) is None:
        skip(f"{what}: {module} is not installed")


try:
    import numpy

    import stiction
except ImportError as error:
    skip(f"all tests of the Python package: {error}")

ROBOTS = stiction.robots()
SCENARIOS = stiction.scenarios()

# Attributes of a state.
STATE = (
    "time",
    "base_position",
    "base_orientation",
    "base_linear_velocity",
    "base_angular_velocity",
    "q",
    "qd",
    "effort",
)

# Columns of the summary that two equal runs do not share.
TIMES = ("wall_s", "cpu_s", "real_time_factor", "avoidance_cpu_s", "avoidance_cycles_cpu_s")


def is_time(column):
    """Returns whether a column of the summary is a measured time."""
    return column in TIMES or column.startswith("timing_")


def block(**more):
    """A block of 1 kg that slides at 1 m/s on a floor of friction 0.3 for 0.1 s, as a dictionary."""
    robot = {"model": ROBOTS / "block" / "block.toml", "base": {"linear_velocity": [1.0, 0.0, 0.0]}}
    return {"duration": 0.1, "robot": robot, "floor": {"friction": 0.3}, **more}


def hoap2(**more):
    """HOAP-2 stands for 0.5 s, with steps that end at control ticks, as a dictionary."""
    robot = {"model": ROBOTS / "hoap2" / "hoap2.toml"}
    return {"duration": 0.5, "robot": robot, "control": {"idle_ticks": True}, **more}


def door(**more):
    """A door of 20 kg on a hinge without friction, which is driven by efforts, for 1 s, as a dictionary."""
    robot = {"model": ROBOTS / "door" / "door.urdf", "joint_default": {"mode": "force"}}
    return {"duration": 1.0, "robot": robot, **more}


def command(*arguments, code=0):
    """Runs the command of the package; returns its standard output."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path))
    call = [sys.executable, "-m", "stiction", *map(str, arguments)]
    done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != code:
        raise AssertionError(f"{call}: exit code {done.returncode}, not {code}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def summary_rows(folder):
    """Rows of a summary as text, without times."""
    with open(Path(folder) / "summary.csv", newline="") as file:
        return [{name: cell for name, cell in row.items() if not is_time(name)} for row in csv.DictReader(file)]


def record(path):
    """A record without times, and without the hash of the whole, which includes them."""
    values = json.loads(Path(path).read_text())
    del values["timing"], values["checksum"]
    return values


@contextmanager
def counting():
    """Counts on another thread, which runs only while the lock of the interpreter is released on purpose.

    Gives a list with the count.
    """
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            # Releases the interpreter's lock.
            time.sleep(0)

    thread = threading.Thread(target=count)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    try:
        thread.start()
        yield counted
    finally:
        done.set()
        sys.setswitchinterval(interval)
        thread.join()


class FolderTest(unittest.TestCase):
    """A test with a temporary folder."""

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = Path(kept.name).resolve()

    def write(self, name, text):
        """Writes a file; returns its path."""
        path = self.folder / name
        path.write_text(text)
        return path

    def assert_same_results(self, one, other):
        """Asserts that two folders have the same runs to the bit: summary, records and logs, without times."""
        rows = summary_rows(one)
        self.assertTrue(rows)
        self.assertEqual(rows, summary_rows(other))
        files = sorted(path.relative_to(one) for path in Path(one).glob("*/*/*") if path.is_file())
        self.assertEqual(files, sorted(path.relative_to(other) for path in Path(other).glob("*/*/*")))
        for file in files:
            if file.name == "run.json":
                self.assertEqual(record(one / file), record(other / file), file)
            else:
                self.assertEqual((one / file).read_bytes(), (other / file).read_bytes(), file)

    def assert_same_bits(self, one, other):
        """Asserts that two states are equal to the bit."""
        for name in STATE:
            numpy.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)
