"""Tables: columns, keys, exact numbers."""

import math
import os
import unittest

from support import FolderTest, case_data

from stiction_engines import case, rows, sweep, tables

CHOICES = {
    "fake": {
        "name": "fake",
        "version": "1.2",
        "settings": [
            {"name": "fixed", "steps": [0.1], "adaptive": False},
            {"name": "adaptive", "steps": [1e-6], "adaptive": True},
        ],
    }
}


class Rows(FolderTest):
    def written(self, *results):
        known = self.case()
        cells = sweep.cells([known], CHOICES)
        file = rows.write_summary(self.folder, [known], cells, results)
        return file.read_text().splitlines()[0].split(","), rows.read_cells(self.folder)

    def passed(self, **more):
        given = {
            "wall": 0.25,
            "duration": 1.0,
            "steps": 10,
            "values": {"distance": 1.6},
            "errors": {"distance": -0.1},
        }
        return sweep.Result("passed", "", **(given | more))

    def test_columns(self):
        columns, (fixed, adaptive) = self.written(
            self.passed(cpu=0.1 + 0.2, noise=(0.01, 0.5)), self.passed(steps=None)
        )
        self.assertEqual(
            columns,
            [
                "scenario",
                "key",
                "outcome",
                "message",
                "method",
                "integrator",
                "seed",
                "integrator.step",
                "integrator.relative_tolerance",
                "duration_s",
                "wall_s",
                "cpu_s",
                "real_time_factor",
                "steps",
                "error_distance",
            ],
        )
        details = (self.folder / "details.csv").read_text().splitlines()[0].split(",")
        own = ["engine_version", "cpu_per_step_us", "noise", "noise_max"]
        self.assertEqual(details, ["key", *own, "value_distance", "error_distance"])
        self.assertEqual([fixed["integrator.step"], fixed["integrator.relative_tolerance"]], ["0.1", ""])
        self.assertEqual(
            [adaptive["integrator.step"], adaptive["integrator.relative_tolerance"]], ["", "1e-06"]
        )
        self.assertEqual(
            [fixed[c] for c in ("scenario", "method", "integrator", "seed")],
            ["by-hand", "fake", "fixed", "1"],
        )
        self.assertEqual(fixed["error_distance"], "-0.1")
        self.assertEqual(rows.read(self.folder / "summary.csv")[0]["error_distance"], "0.1")
        self.assertEqual(fixed["cpu_s"], "0.30000000000000004")
        self.assertAlmostEqual(float(fixed["cpu_per_step_us"]), 3e4)
        self.assertEqual(
            [fixed["real_time_factor"], fixed["noise"], fixed["noise_max"]], ["4.0", "0.01", "0.5"]
        )
        self.assertEqual([adaptive[c] for c in ("cpu_s", "steps", "cpu_per_step_us", "noise")], [""] * 4)
        self.assertEqual(os.listdir(self.folder).count("summary.csv"), 1)
        self.assertFalse([name for name in os.listdir(self.folder) if name.startswith(".")])

    def test_outcomes_and_messages(self):
        lost = self.passed(cost_message='fixed at 0.1: "crash", twice', values={"distance": math.inf})
        _, (first, second) = self.written(sweep.Result("unsupported", "no boxes"), lost)
        self.assertEqual(
            [first[c] for c in ("outcome", "message", "value_distance")], ["unsupported", "no boxes", ""]
        )
        self.assertEqual(second["message"], 'cost not measured: fixed at 0.1: "crash", twice')
        self.assertEqual(second["value_distance"], "inf")

    def test_keys_are_stable_and_depend_on_all(self):
        known = self.case()
        cells = sweep.cells([known], CHOICES)
        keys = [rows.key(cell, known) for cell in cells]
        self.assertEqual(keys, ["4e4809aded69c881", "615ce789514f812c"])
        self.assertNotEqual(rows.key(cells[0], self.case(case_data(duration=2.0))), keys[0])
        for change in [{"engine": "b"}, {"version": "2"}, {"settings": "c"}, {"step": 0.2}]:
            changed = sweep.Cell(**(vars(cells[0]) | change))
            self.assertNotEqual(rows.key(changed, self.case()), keys[0], change)
        heavier = (self.folder / "box.urdf").read_text().replace('"2"', '"3"')
        self.assertNotEqual(rows.key(cells[0], self.case(urdf=heavier)), keys[0])

    def test_keys_of_a_sweep_differ(self):
        cases = case.read_all()
        cells = sweep.cells(cases, CHOICES)
        by_name = {known.name: known for known in cases}
        self.assertEqual(len({rows.key(cell, by_name[cell.case]) for cell in cells}), len(cells))

    def test_truths(self):
        (row,) = rows.read(rows.write_truths(self.folder, [self.case()]))
        self.assertEqual(
            row,
            {
                "case": "by-hand",
                "measure": "distance",
                "truth": "1.5",
                "truth_error": "0.0",
                "unit": "m",
                "derivation": "by hand",
            },
        )

    def test_steps_and_tolerances_replace_those_of_the_settings(self):
        cells = sweep.cells([self.case()], CHOICES, steps=[0.5, 0.2], tolerances=[1e-3])
        self.assertEqual([cell.step for cell in cells], [0.5, 0.2, 1e-3])
        self.assertEqual(
            [c.settings for c in sweep.cells([self.case()], CHOICES, settings=["adaptive"])], ["adaptive"]
        )


class Digits(unittest.TestCase):
    def test_two_significant(self):
        for number, text in [
            (0.0, "0"),
            (0.1, "0.10"),
            (-0.00123, "-0.0012"),
            (1.26e-4, "1.3e-04"),
            (9.96, "10"),
            (123.0, "123"),
            (0.0999, "0.10"),
            (math.inf, "inf"),
            (12345.0, "1.2e+04"),
        ]:
            self.assertEqual(tables.digits(number), text)


if __name__ == "__main__":
    unittest.main()
