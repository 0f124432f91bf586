"""Tables: time series against the command's CSV, the summary against summary.csv, selection of runs."""

import csv
import importlib
import math
import unittest
from unittest import mock

from support import FolderTest, block, command, hoap2, need, numpy, stiction

SWEEP = {
    "grid": {
        "floor.friction": [0.2, 0.5],
        "control.idle_ticks": [True, False],
        "robot.base.linear_velocity": [[1.0, 0, 0], [2.0, 0, 0]],
    }
}


def read_csv(text):
    """Columns of a CSV as lists of text."""
    header, *rows = csv.reader(text.splitlines())
    return {name: [row[i] for row in rows] for i, name in enumerate(header)}


class SeriesOfALog(FolderTest):
    @classmethod
    def setUpClass(cls):
        push = {"type": "push", "link": "torso", "force": [15, 0, 0], "start": 0.1, "duration": 0.1}
        cls.results = stiction.run(hoap2(force=[push], robot=hoap2()["robot"]), progress=False)
        (cls.run_,) = cls.results

    def assert_equal_to_csv(self, series, *options):
        """Asserts that a series has the names and values of `runner export` to the bit."""
        columns = read_csv(command("export", self.run_.log, *options))
        self.assertEqual(list(series), list(columns))
        for name, cells in columns.items():
            values = series[name]
            self.assertEqual(len(values), len(cells))
            if values.dtype == object:
                self.assertEqual([text or "" for text in values], cells, name)
            elif values.dtype == bool:
                self.assertEqual([str(flag).lower() for flag in values], cells, name)
            else:
                expected = [float(cell) if cell else math.nan for cell in cells]
                numpy.testing.assert_array_equal(values.astype(float), expected, name)

    def test_all_columns(self):
        series = self.run_.series()
        self.assertEqual(self.run_.columns(), command("export", self.run_.log, "--list-columns").split())
        self.assertEqual(list(series), self.run_.columns())
        self.assert_equal_to_csv(series)

    def test_wildcards_and_one_name(self):
        names = ["com_z_m", "sole.*.state", "joint.left_knee.*"]
        self.assert_equal_to_csv(self.run_.series(names), "--columns", ",".join(names))
        self.assertEqual(self.run_.series("com_z_m").columns, ("time_s", "com_z_m"))

    def test_rate_and_range(self):
        series = self.run_.series("*", rate=130, start=0.05, end=0.4)
        self.assert_equal_to_csv(series, "--rate", 130, "--from", 0.05, "--to", 0.4)

    def test_events(self):
        rows = read_csv(command("export", self.run_.log, "--events"))
        found = [(event.time, event.kind, event.subject, event.message) for event in self.run_.events]
        times = map(float, rows["time_s"])
        self.assertEqual(found, list(zip(times, rows["kind"], rows["subject"], rows["message"], strict=True)))

    def test_a_log_alone(self):
        log = stiction.Log(self.run_.log)
        self.assertEqual(log.columns(), self.run_.columns())
        self.assertEqual(log.events, self.run_.events)
        numpy.testing.assert_array_equal(log.series("com_z_m")["com_z_m"], self.run_.series("com_z_m")["com_z_m"])

    def test_data_frames(self):
        series = self.run_.series(["com_?_m", "sole.left.state", "sole.left.vertex0.clamped"])
        for method in ("to_arrow", "to_pandas", "to_polars"):
            with self.subTest(method):
                need({"to_arrow": "pyarrow", "to_pandas": "pandas", "to_polars": "polars"}[method], method)
                frame = getattr(series, method)()
                self.assertEqual(len(frame), len(series))
                for name in series:
                    values = numpy.array(frame[name].to_pylist() if method == "to_arrow" else frame[name].to_list())
                    numpy.testing.assert_array_equal(values, numpy.array(series[name].tolist()), name)

    def test_unknown_columns(self):
        with self.assertRaisesRegex(stiction.LogError, "com_zz_m"):
            self.run_.series("com_zz_m")
        with self.assertRaisesRegex(KeyError, "did you mean 'com_z_m'"):
            self.run_.series("com_?_m")["comz_m"]

    def test_broken_logs(self):
        with self.assertRaises(stiction.LogError):
            stiction.Log(self.folder / "none.mcap").series()
        with self.assertRaises(stiction.LogError):
            stiction.Log(self.write("broken.mcap", "no log")).columns()

    def test_arrays_are_new(self):
        series = self.run_.series("com_z_m")
        series["time_s"][:] = 0.0
        self.assertGreater(series["time_s"][-1], 0.0)


class SummaryOfABatch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.results = stiction.run(block(sweep=SWEEP), log=False, progress=False)
        with open(cls.results.folder / "summary.csv", newline="") as file:
            cls.rows = list(csv.DictReader(file))

    def assert_equal_to_csv(self, names, column):
        """Asserts that a table has the cells of summary.csv; `column` gives the values of one as a list."""
        self.assertEqual(list(names), list(self.rows[0]))
        for name in names:
            for value, row in zip(column(name), self.rows, strict=True):
                cell = row[name]
                missing = value is None or (isinstance(value, float) and math.isnan(value))
                if cell == "" or missing:
                    self.assertTrue(missing and cell == "", (name, cell, value))
                elif isinstance(value, str):
                    self.assertEqual(value, cell, name)
                else:
                    self.assertEqual(float(value), float(cell), name)

    def test_arrays(self):
        summary = self.results.summary
        self.assertEqual(len(summary), 8)
        self.assert_equal_to_csv(summary.columns, lambda name: summary[name].tolist())

    def test_arrow(self):
        need("pyarrow", "Arrow")
        table = self.results.summary.to_arrow()
        self.assert_equal_to_csv(table.column_names, lambda name: table[name].to_pylist())

    def test_pandas(self):
        need("pandas", "pandas")
        frame = self.results.summary.to_pandas()
        self.assert_equal_to_csv(frame.columns, lambda name: frame[name].tolist())

    def test_polars(self):
        need("polars", "Polars")
        frame = self.results.summary.to_polars()
        self.assert_equal_to_csv(frame.columns, lambda name: frame[name].to_list())

    def test_missing_packages_are_named(self):
        def missing(name):
            raise ImportError(name)

        with mock.patch.object(importlib, "import_module", missing):
            for method, package in (("to_arrow", "pyarrow"), ("to_pandas", "pandas"), ("to_polars", "polars")):
                with self.assertRaisesRegex(ImportError, f"pip install {package}"):
                    getattr(self.results.summary, method)()

    def test_selection(self):
        results = self.results
        self.assertEqual(results.summary.parameters, tuple(SWEEP["grid"]))
        self.assertEqual(len(results.select({"floor.friction": 0.2})), 4)
        self.assertEqual(len(results.select({"control.idle_ticks": True, "floor.friction": numpy.float64(0.2)})), 2)
        run = results.run(
            {"control.idle_ticks": False, "floor.friction": 0.5, "robot.base.linear_velocity": numpy.array([2, 0, 0])}
        )
        self.assertEqual(
            run.parameters,
            {"floor.friction": 0.5, "control.idle_ticks": False, "robot.base.linear_velocity": "[2.0, 0, 0]"},
        )
        self.assertEqual([run.key for run in results], list(results.runs))
        self.assertEqual(len(results.select(scenario="scenario", outcome="passed", method="exact")), 8)
        with self.assertRaisesRegex(KeyError, "floor.friction is 0.2, 0.5, never 0.3"):
            results.run({"floor.friction": 0.3})
        with self.assertRaisesRegex(KeyError, "did you mean 'floor.friction'"):
            results.select({"floor.frction": 0.3})
        with self.assertRaisesRegex(ValueError, "4 runs match"):
            results.run({"floor.friction": 0.5})

    def test_metrics(self):
        for run, row in zip(self.results, self.rows, strict=True):
            self.assertEqual(run.metrics["final_base_x"], float(row["final_base_x"]))
            self.assertTrue(math.isnan(run.metrics["first_fall_s"]))
            self.assertNotIn("floor.friction", run.metrics)

    def test_pages_of_notebooks(self):
        page = self.results._repr_html_()
        self.assertIn("8 runs: 8 passed", page)
        self.assertIn("<th>floor.friction</th>", page)
        self.assertIn("8 rows", self.results.summary._repr_html_())
        self.assertIn("passed", next(iter(self.results))._repr_html_())


if __name__ == "__main__":
    unittest.main()
