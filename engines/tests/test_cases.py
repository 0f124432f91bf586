"""The cases of the package: their files agree with the schema, and with the script that writes them."""

import importlib.util
import json
import subprocess
import sys
import unittest
from pathlib import Path

import support  # noqa: F401

from stiction_engines import case, measure, mechanics

FOLDER = Path(__file__).resolve().parents[1]


class Cases(unittest.TestCase):
    def test_all_are_complete(self):
        cases = case.read_all()
        self.assertGreaterEqual(len(cases), 24)
        for known in cases:
            with self.subTest(case=known.name):
                self.assertEqual(known.file.stem, known.name)
                self.assertTrue(known.measures)
                # Every step divides the duration.
                self.assertAlmostEqual(known.duration / 4e-3, round(known.duration / 4e-3), places=9)
                for m in known.measures:
                    self.assertIn(m.kind, [*measure.KINDS, *measure.MECHANICAL])
                    self.assertIn(m.body, [body.name for body in known.bodies])
                    self.assertGreaterEqual(m.truth_error, 0.0)
                for body in known.bodies:
                    links = mechanics.Mechanism(body).links
                    self.assertTrue(set(body.touching) <= set(links), body.touching)

    def test_they_agree_with_the_schema(self):
        if importlib.util.find_spec("jsonschema") is None:
            self.skipTest("jsonschema is not installed")
        import jsonschema

        schema = json.loads((case.folder() / "case.schema.json").read_text())
        for known in case.read_all():
            with self.subTest(case=known.name):
                jsonschema.validate(json.loads(known.file.read_text()), schema)

    def test_they_are_as_the_script_writes_them(self):
        if importlib.util.find_spec("scipy") is None:
            self.skipTest("scipy is not installed")
        command = [sys.executable, FOLDER / "make_cases.py", "--check"]
        ended = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(ended.returncode, 0, ended.stderr)


if __name__ == "__main__":
    unittest.main()
