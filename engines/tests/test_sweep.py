"""Workers, sweep and costs with an engine that fails in each way."""

import contextlib
import io
import math
import os
import time
import unittest
from pathlib import Path

from support import FAKE, FolderTest

from stiction_engines import adapters, case, cost, rows, sweep
from stiction_engines.__main__ import main
from stiction_engines.worker_process import Crashed, TimedOut, WorkerProcess, described


def fake_cells(*settings):
    return sweep.cells(case.read_all(["slide-0"]), described([FAKE]), settings)


class Workers(FolderTest):
    def outcome(self, setting, limit=30.0):
        cells = fake_cells(setting, "works")
        results, complete = sweep.run(cells, 1, limit)
        self.assertTrue(complete)
        by_setting = {cell.settings: result for cell, result in zip(cells, results)}
        # The sweep continues after a failure.
        self.assertEqual(by_setting["works"].outcome, "passed", by_setting["works"].message)
        return by_setting[setting]

    def test_measures_arrive(self):
        result = self.outcome("works")
        self.assertEqual(result.steps, 60)
        self.assertAlmostEqual(result.duration, 0.6)
        self.assertEqual(set(result.values), {"stop_distance", "sideways", "stop_time"})
        # The fake engine has no error but rounding. The measure of `stop_time` interpolates in the step in
        # which the box stops.
        self.assertLess(abs(result.errors["stop_distance"]), 1e-12)
        self.assertLess(abs(result.errors["stop_time"]), 0.01)

    def test_output_of_engines_does_not_disturb(self):
        self.assertEqual(self.outcome("prints").outcome, "passed")

    def test_numbers_that_are_not_finite(self):
        result = self.outcome("not-finite")
        self.assertEqual(result.outcome, "passed")
        self.assertEqual(result.errors["stop_time"], math.inf)

    def test_time_limit(self):
        begin = time.monotonic()
        result = self.outcome("sleeps", limit=1.0)
        self.assertEqual((result.outcome, result.message), ("timed-out", "more than 1 s"))
        self.assertLess(time.monotonic() - begin, 20)

    def test_crash(self):
        result = self.outcome("crashes")
        self.assertEqual(result.outcome, "error")
        self.assertEqual(result.message, "the engine's process ended by SIGSEGV: assertion failed")

    def test_exit(self):
        result = self.outcome("exits")
        self.assertEqual(
            (result.outcome, result.message), ("error", "the engine's process exited with code 7")
        )

    def test_reasons(self):
        for setting, outcome, message in [
            ("fails", "diverged", "too fast"),
            ("lacks", "unsupported", "no boxes"),
            ("raises", "error", "ValueError: two lines"),
        ]:
            result = self.outcome(setting)
            self.assertEqual((result.outcome, result.message), (outcome, message))

    def test_processes_and_folders_are_gone(self):
        for setting, limit, expected in [("sleeps", 1.0, TimedOut), ("exits", 60.0, Crashed)]:
            worker = WorkerProcess()
            (cell,) = fake_cells(setting)
            with self.assertRaises(expected):
                worker.ask(cell.request("accuracy"), limit)
            self.assertIsNotNone(worker.process.returncode)
            self.assertFalse(Path(worker.folder).exists())

    def test_adapters_that_cannot_be_loaded(self):
        (self.folder / "absent.py").write_text(
            "import no_such_engine\nclass Adapter:\n    package = 'engine-absent'\n"
        )
        (self.folder / "broken.py").write_text("import os\nos.abort()\n")
        absent, broken = str(self.folder / "absent.py"), str(self.folder / "broken.py")
        found = described([absent, broken])
        self.assertEqual(found[absent]["missing"], "not installed (pip install engine-absent)")
        self.assertEqual(found[broken]["missing"], "cannot be loaded (the engine's process ended by SIGABRT)")

    def test_adapters_of_the_package_name_what_to_install(self):
        self.assertLessEqual({"drake", "mujoco", "pinocchio", "pybullet", "stiction"}, set(adapters.names()))
        self.assertEqual(adapters.package("pinocchio"), "pin")


class Costs(unittest.TestCase):
    def test_a_crash_loses_the_costs_of_its_engine_only(self):
        cells = fake_cells("works", "fails", "crashes-in-cost")
        results, _ = sweep.run(cells, 2, 30.0)
        by_setting = {cell.settings: result for cell, result in zip(cells, results)}
        self.assertTrue(cost.run(cells, results, 2))
        self.assertIsNone(by_setting["fails"].cpu)
        self.assertIsNone(by_setting["crashes-in-cost"].cpu)
        self.assertIn("ended by SIGSEGV", by_setting["works"].cost_message)

    def test_the_least_of_the_rounds_and_the_noise(self):
        cells = fake_cells("works", "prints")
        results, _ = sweep.run(cells, 2, 30.0)
        seen = []
        self.assertTrue(cost.run(cells, results, 3, lambda name, pairs: seen.append((name, len(pairs)))))
        self.assertEqual(seen, [("slide-0", 2)])
        for result in results:
            self.assertEqual((result.cpu, result.steps), (0.005, 60))
            self.assertGreaterEqual(result.noise[1], result.noise[0])
            self.assertGreaterEqual(result.noise[0], 0.0)


class Command(FolderTest):
    def call(self, *arguments):
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            code = main([str(argument) for argument in arguments])
        return code, output.getvalue(), errors.getvalue()

    def test_run_and_tables(self):
        code, output, _ = self.call(
            "run",
            "--engines",
            FAKE,
            "--cases",
            "slide-0",
            "--settings",
            "works",
            "lacks",
            "fails",
            "--rounds",
            1,
            "-j",
            1,
            "-o",
            self.folder / "out",
        )
        self.assertEqual(code, 0, output)
        self.assertRegex(output, r"slide-0 +fake +1 of 3 passed, 1 diverged, 1 unsupported  \d+\.\d s")
        self.assertIn("fake: no boxes (slide-0)", output)
        self.assertEqual(
            sorted(os.listdir(self.folder / "out")), ["details.csv", "summary.csv", "truths.csv"]
        )
        table = {row["integrator"]: row for row in rows.read(self.folder / "out/summary.csv")}
        self.assertEqual(table["works"]["cpu_s"], "0.005")
        self.assertEqual(table["lacks"]["outcome"], "unsupported")
        code, output, _ = self.call("tables", self.folder / "out", "--step", 0.01)
        self.assertEqual(code, 0)
        self.assertRegex(output, r"\| slide-0 stop_time \(s\) \| [-0-9.e]+ \| diverged \| - \|")
        self.assertIn("| fake lacks | no boxes | slide-0 |", output)

    def test_wrong_arguments(self):
        for arguments, message in [
            (["--engines", "odee"], "error: unknown engine 'odee'; known: drake, "),
            (["--engines", "odee.py"], "error: odee.py: no such file, expected an adapter"),
            (["--cases", "slide", "nope"], "error: unknown case 'nope'; known: ball-begins-to-roll, "),
            (["--engines", FAKE, "--settings", "best"], "error: unknown settings 'best'; known: works, "),
        ]:
            code, _, errors = self.call("run", *arguments, "-o", self.folder)
            self.assertEqual(code, 2)
            self.assertTrue(errors.startswith(message), errors)
        code, _, errors = self.call("tables", self.folder / "none")
        self.assertEqual(code, 2)
        self.assertIn("summary.csv: no such file", errors)


if __name__ == "__main__":
    unittest.main()
