"""Helps the tests: finds the package, makes series and cases by hand, skips what is not installed."""

import importlib.util
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
FAKE = str(Path(__file__).resolve().parent / "fake_engine.py")


def skip(reason):
    """Prints that a test is skipped, and skips it."""
    print(f"skipped: {reason}", file=sys.stderr)
    raise unittest.SkipTest(reason)


def need(module, what):
    """Skips without a module."""
    if importlib.util.find_spec(module) is None:
        skip(f"{what}: {module} is not installed")


need("numpy", "all tests of the engines")

import numpy  # noqa: E402

from stiction_engines import case  # noqa: E402
from stiction_engines.series import BodySeries, Series  # noqa: E402


def body_series(count, **given):
    """A `BodySeries` of `count` rows: at rest at the origin, but for what is given."""
    zeros = lambda width: numpy.zeros((count, width))
    fields = {
        "position": zeros(3),
        "orientation": numpy.tile([1.0, 0, 0, 0], (count, 1)),
        "linear_velocity": zeros(3),
        "angular_velocity": zeros(3),
        "q": zeros(0),
        "qd": zeros(0),
    }
    return BodySeries(**(fields | {key: numpy.array(value, dtype=float) for key, value in given.items()}))


def series(time, **given):
    """A `Series` of one body, `box`."""
    return Series(numpy.array(time, dtype=float), {"box": body_series(len(time), **given)})


def about(axis, angles):
    """Quaternions of rotations about an axis."""
    half = numpy.asarray(angles, dtype=float)[:, None] / 2
    return numpy.hstack([numpy.cos(half), numpy.sin(half) * numpy.asarray(axis, dtype=float)])


URDF = """<robot name="box"><link name="box"><inertial><mass value="2"/>
<inertia ixx="0.1" iyy="0.2" izz="0.3"/></inertial></link></robot>
"""


def case_data(**changes):
    """The JSON of a case of one box, with changes."""
    body = {"name": "box", "urdf": "box.urdf", "position": [0, 0, 1], "touching": {}}
    measure = {
        "name": "distance",
        "kind": "along",
        "body": "box",
        "unit": "m",
        "truth": 1.5,
        "truth_error": 0.0,
        "derivation": "by hand",
        "direction": [1, 0, 0],
    }
    return {
        "format": case.FORMAT,
        "name": "by-hand",
        "title": "A case",
        "family": "tests",
        "gravity": [0, 0, -10],
        "bodies": [body],
        "friction": [],
        "forces": [],
        "duration": 1.0,
        "measures": [measure],
    } | changes


class FolderTest(unittest.TestCase):
    """Tests with a temporary folder."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def case(self, data=None, urdf=URDF):
        """A case, written and read."""
        (self.folder / "box.urdf").write_text(urdf)
        file = self.folder / "by-hand.json"
        file.write_text(json.dumps(data or case_data()))
        return case.read(file)
