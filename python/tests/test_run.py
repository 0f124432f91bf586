"""Batches: closed forms, sweeps, the same bits as the command, progress, interruption and resumption."""

import gc
import io
import pickle
import shutil
import signal
import subprocess
import sys
import unittest
from unittest import mock

from support import REPOSITORY, ROBOTS, SCENARIOS, FolderTest, block, command, hoap2, need, numpy, stiction

GRAVITY = 9.81

INTERRUPTED = """
import sys
sys.path[:0] = {path!r}
import stiction
from support import block, hoap2

def shown(message):
    if message["event"] == "run-finished" and message["outcome"] == "passed":
        print("ready", flush=True)

try:
    # The first run is short, the second would last for hours.
    long = hoap2(duration=1e5, stop={{}}, log={{"rate": 0}})
    stiction.run([block(), long], output={output!r}, jobs=1, progress=shown)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


class ClosedForms(unittest.TestCase):
    def test_sliding_block_stops_after_v2_over_2_mu_g(self):
        results = stiction.run(SCENARIOS / "sliding-block.toml", progress=False)
        self.assertTrue(results.passed)
        self.assertEqual(results.outcomes, {"passed": 1})
        (run,) = results
        distance = 2.0**2 / (2 * 0.5 * GRAVITY)
        # The deceleration is constant, so steps are exact; rounding of the location of the stop dominates.
        self.assertAlmostEqual(run.metrics["final_base_x"], distance, delta=1e-12)
        self.assertAlmostEqual(run.metrics["first_stick_s"], 2.0 / (0.5 * GRAVITY), delta=1e-12)
        self.assertTrue(all(expectation.held for expectation in run.expectations))
        self.assertEqual(len(run.expectations), 5)
        series = run.series(["base_x_m", "base_vx_m_s"])
        moving = series["time_s"] < 2.0 / (0.5 * GRAVITY)
        time = series["time_s"][moving]
        # Rounding of 100 steps.
        expected = 2.0 * time - 0.5 * 0.5 * GRAVITY * time**2
        numpy.testing.assert_allclose(series["base_x_m"][moving], expected, atol=1e-13)

    def test_sweep_of_a_dictionary(self):
        friction = [0.2, 0.4, 0.8]
        sweep = {"grid": {"floor.friction": friction, "contact.method": ("exact", "one-step")}}
        results = stiction.run(block(duration=1.0, sweep=sweep), log=False, progress=False)
        self.assertEqual(len(results), 6)
        self.assertEqual(results.summary.parameters, ("floor.friction", "contact.method"))
        for coefficient in friction:
            run = results.run({"contact.method": "exact", "floor.friction": coefficient})
            self.assertEqual(run.parameters, {"floor.friction": coefficient, "contact.method": "exact"})
            # As above.
            self.assertAlmostEqual(run.metrics["final_base_x"], 0.5 / (coefficient * GRAVITY), delta=1e-12)
        # NumPy values are those of Python.
        sweep = {"grid": {"floor.friction": numpy.array(friction), "contact.method": ["exact", "one-step"]}}
        again = stiction.Scenario(block(duration=numpy.float64(1.0), sweep=sweep)).runs()
        self.assertEqual([run.key for run in again], list(results.runs))

    def test_set_replaces_values(self):
        results = stiction.run(
            block(duration=1.0), set={"floor.friction": 0.6, "robot.base.linear_velocity": (2, 0, 0)}, progress=False
        )
        (run,) = results
        # As above.
        self.assertAlmostEqual(run.metrics["final_base_x"], 2.0 / (0.6 * GRAVITY), delta=1e-12)


class AgainstTheCommand(FolderTest):
    def test_bits_of_files(self):
        files = [SCENARIOS / name for name in ("sliding-block.toml", "friction-sweep.toml", "push.toml")]
        command(*files, "-o", self.folder / "command", "--set", "duration=0.5", code=1)
        # The push of push.toml would begin as the run ends.
        with self.assertWarnsRegex(stiction.ScenarioWarning, "the run ends at 0.5 s"):
            results = stiction.run(files, set={"duration": 0.5}, output=self.folder / "python", progress=False)
        self.assert_same_results(self.folder / "command", results.folder)
        command("compare", self.folder / "command", results.folder, "--absolute", 0, "--relative", 0)

    def test_bits_of_a_dictionary(self):
        values = block(duration=0.3, sweep={"grid": {"contact.method": ["exact", "one-step"]}})
        results = stiction.run(values, output=self.folder / "python", progress=False)
        file = self.write("scenario.toml", stiction.Scenario(values).text)
        command(file, "-o", self.folder / "command")
        self.assert_same_results(self.folder / "command", results.folder)

    def test_bits_of_1000_short_runs(self):
        grid = {"floor.friction": {"linspace": [0.1, 0.9, 250]}, "contact.method": ["exact", "one-step"]}
        values = block(duration=0.02, sweep={"grid": grid, "repeat": 2})
        results = stiction.run(values, output=self.folder / "python", progress=False, log=False)
        self.assertEqual(len(results), 1000)
        file = self.write("scenario.toml", stiction.Scenario(values).text)
        command(file, "-o", self.folder / "command", "--no-log")
        self.assert_same_results(self.folder / "command", results.folder)

    def test_keys_of_list(self):
        listed = [line.split() for line in command("list", SCENARIOS / "friction-sweep.toml").splitlines()]
        runs = stiction.Scenario(SCENARIOS / "friction-sweep.toml").runs()
        self.assertEqual([run.key for run in runs], [line[1] for line in listed])
        self.assertEqual([run.label for run in runs], [" ".join(line[2:]) for line in listed])

    def test_command_of_the_package(self):
        self.assertEqual(command("--version").split()[-1], stiction.__version__)
        command("check", self.folder / "none.toml", code=2)


class Sources(FolderTest):
    def test_a_folder_stands_for_its_files(self):
        text = stiction.Scenario(block()).text
        for name in ("b.toml", "a.toml", "c.txt"):
            self.write(name, text)
        results = stiction.run(self.folder, progress=False, log=False)
        self.assertEqual(results.summary["scenario"].tolist(), ["a", "b"])
        # Equal files have runs of equal keys.
        first, second = results.runs
        key = first.removeprefix("a/")
        self.assertEqual((first, second), (f"a/{key}", f"b/{key}"))
        self.assertEqual(results.runs[second].scenario, "b")
        with self.assertRaisesRegex(KeyError, "several scenarios"):
            results.runs[key]

    def test_dictionaries_are_numbered(self):
        results = stiction.run([block(), block(floor={"friction": 0.5})], progress=False, log=False)
        self.assertEqual(results.summary["scenario"].tolist(), ["scenario-1", "scenario-2"])

    def test_scenarios_with_values_of_their_own(self):
        scenario = stiction.Scenario(block(duration=1.0), name="rubber")
        ice = scenario.with_set({"floor.friction": 0.1}, name="ice")
        results = stiction.run([scenario, ice], set={"duration": 2.0}, progress=False, log=False)
        rubber, slippery = results.select(scenario="rubber")[0], results.select(scenario="ice")[0]
        # As in ClosedForms.
        self.assertAlmostEqual(rubber.metrics["final_base_x"], 0.5 / (0.3 * GRAVITY), delta=1e-12)
        self.assertAlmostEqual(slippery.metrics["final_base_x"], 0.5 / (0.1 * GRAVITY), delta=1e-12)
        alone = stiction.run(ice, set={"duration": 2.0}, progress=False, log=False)
        self.assertEqual(list(alone.runs), [slippery.key])

    def test_text_and_relative_paths(self):
        text = 'duration = 0.1\nrobot = { model = "block/block.toml" }\n'
        scenario = stiction.Scenario.parse(text, name="standing", folder=ROBOTS)
        self.assertEqual(scenario.name, "standing")
        self.assertEqual(scenario.path, ROBOTS / "standing.toml")
        self.assertTrue(scenario.run(progress=False, log=False).passed)
        same = stiction.Scenario({"duration": 0.1, "robot": {"model": "block/block.toml"}}, folder=ROBOTS)
        self.assertEqual(same.runs()[0].key, scenario.runs()[0].key)
        copy = stiction.Scenario(self.write("other.toml", text), folder=ROBOTS)
        self.assertEqual((copy.name, copy.runs()[0].key), ("other", scenario.runs()[0].key))

    def test_scenarios_are_pickled(self):
        scenario = stiction.Scenario(SCENARIOS / "sliding-block.toml", set={"floor.friction": 0.25})
        copy = pickle.loads(pickle.dumps(scenario))
        self.assertEqual(copy.runs(), scenario.runs())
        self.assertEqual(copy.values, {"floor.friction": 0.25})

    def test_wrong_sources(self):
        with self.assertRaisesRegex(ValueError, "Scenario.parse"):
            stiction.run("duration = 1\n")
        with self.assertRaisesRegex(TypeError, "not int"):
            stiction.run([1])
        with self.assertRaisesRegex(ValueError, "not a path"):
            stiction.Scenario(block(), name="a/b")


class ResultsOfRuns(FolderTest):
    def test_failed_runs_do_not_raise(self):
        expect = [{"metric": "final_base_x", "value": 0.0, "tolerance": 1e-3}]
        sweep = {"grid": {"robot.base.linear_velocity": [[0.0, 0, 0], [1.0, 0, 0]]}}
        results = stiction.run(block(expect=expect, sweep=sweep), progress=False)
        self.assertFalse(results.passed)
        self.assertEqual(results.outcomes, {"passed": 1, "failed": 1})
        (failed,) = results.failed
        self.assertEqual(failed.key, results.run({"robot.base.linear_velocity": [1, 0, 0]}, outcome="failed").key)
        (expectation,) = failed.expectations
        self.assertEqual((expectation.metric, expectation.held, expectation.value), ("final_base_x", False, 0.0))
        self.assertEqual(expectation.measured, failed.metrics["final_base_x"])
        self.assertIn("final_base_x", failed.message)
        self.assertFalse(stiction.load(results.folder).passed)

    def test_an_expected_outcome_passes(self):
        values = hoap2(expect=[{"outcome": "timed-out"}], duration=1e5, log={"rate": 0})
        results = stiction.run(values, timeout=0.2, progress=False)
        self.assertEqual(results.outcomes, {"timed-out": 1})
        self.assertTrue(results.passed)
        self.assertTrue(stiction.load(results.folder).passed)

    def test_runs_that_were_not_started(self):
        expect = [{"metric": "final_base_x", "max": -1.0}]
        values = block(expect=expect, sweep={"repeat": 5})
        results = stiction.run(values, max_fail=1, jobs=1, progress=False)
        self.assertLess(len(results), 5)
        self.assertFalse(results.passed)

    def test_a_temporary_folder_lives_with_its_runs(self):
        results = stiction.run(block(), progress=False)
        folder, run = results.folder, next(iter(results))
        del results
        gc.collect()
        self.assertGreater(len(run.series("base_x_m")), 1)
        del run
        gc.collect()
        self.assertFalse(folder.exists())

    def test_pickling(self):
        with self.assertRaisesRegex(TypeError, "temporary folder: run with output"):
            pickle.dumps(stiction.run(block(), progress=False))
        results = stiction.run(block(), output=self.folder, progress=False)
        copy = pickle.loads(pickle.dumps(results))
        self.assertEqual(list(copy.runs), list(results.runs))
        run = pickle.loads(pickle.dumps(next(iter(results))))
        self.assertEqual(run.record, next(iter(results)).record)
        with self.assertRaisesRegex(TypeError, "to_pandas"):
            pickle.dumps(results.summary)

    def test_events(self):
        results = stiction.run(SCENARIOS / "sliding-block.toml", progress=False)
        (run,) = results
        (event,) = [event for event in run.events if event.kind == "stick"]
        self.assertEqual(event.subject, "bottom")
        # Times of the log are whole nanoseconds.
        self.assertAlmostEqual(event.time, run.metrics["first_stick_s"], delta=1e-9)
        self.assertEqual(results.events, {run.key: run.events})

    def test_without_logs(self):
        (run,) = stiction.run(block(), log=False, progress=False)
        self.assertIsNone(run.log)
        with self.assertRaisesRegex(stiction.LogError, "has no log"):
            run.series()

    def test_report(self):
        results = stiction.run(block(), output=self.folder, progress=False)
        path = results.report()
        self.assertEqual(path, self.folder / "report.html")
        before = path.read_bytes()
        path.unlink()
        self.assertEqual(results.report().read_bytes(), before)
        self.assertIn("1 run: 1 passed", results._repr_html_())

    def test_a_folder_without_results(self):
        with self.assertRaisesRegex(stiction.ResultsError, "no summary.parquet"):
            stiction.load(self.folder)


class ProgressOfBatches(FolderTest):
    def test_messages(self):
        messages = []
        stiction.run(block(sweep={"repeat": 3}), progress=messages.append)
        events = [message["event"] for message in messages]
        self.assertEqual(events[0], "batch-started")
        self.assertEqual(events.count("run-started"), 3)
        self.assertEqual(events.count("run-finished"), 3)
        self.assertEqual(messages[0]["runs"], 3)
        finished = [message for message in messages if message["event"] == "run-finished"]
        self.assertTrue(all(message["accepted"] and message["outcome"] == "passed" for message in finished))

    def test_an_exception_of_the_function_is_raised(self):
        def shown(message):
            raise LookupError(message["event"])

        with self.assertRaisesRegex(LookupError, "batch-started"):
            stiction.run(block(sweep={"repeat": 3}), progress=shown)

    def test_display_without_tqdm(self):
        with mock.patch.object(stiction._progress, "_tqdm", lambda: None), mock.patch("sys.stderr", io.StringIO()) as shown:
            stiction.run(block(sweep={"repeat": 3}), progress=True)
        self.assertEqual(shown.getvalue(), "\r0/3 runs\r1/3 runs\r2/3 runs\r3/3 runs\n")

    def test_display_with_tqdm(self):
        need("tqdm", "progress by tqdm")
        expect = [{"metric": "final_base_x", "max": -1.0}]
        with mock.patch("sys.stderr", io.StringIO()) as shown:
            stiction.run(block(sweep={"repeat": 3}, expect=expect), progress=True)
        self.assertRegex(shown.getvalue(), "3/3 .*failed=3")

    def test_nothing_is_shown_without_a_terminal(self):
        with mock.patch("sys.stderr", io.StringIO()) as shown:
            stiction.run(block())
        self.assertEqual(shown.getvalue(), "")

    def test_resume_runs_the_rest(self):
        values = block(sweep={"grid": {"floor.friction": [0.1, 0.2, 0.3, 0.4]}})
        whole = stiction.run(values, output=self.folder / "whole", progress=False)
        part = stiction.run(values, output=self.folder / "part", progress=False)
        shutil.rmtree(part.run({"floor.friction": 0.2}).folder)
        messages = []
        resumed = stiction.run(values, output=self.folder / "part", resume=True, progress=messages.append)
        finished = [message for message in messages if message["event"] == "run-finished"]
        self.assertEqual(sum(message["resumed"] for message in finished), 3)
        self.assertEqual(len(finished), 4)
        self.assertTrue(resumed.passed)
        self.assert_same_results(whole.folder, resumed.folder)
        with self.assertRaisesRegex(ValueError, "output"):
            stiction.run(values, resume=True)

    @unittest.skipIf(sys.platform == "win32", "SIGINT cannot be sent to a process on Windows")
    def test_ctrl_c_cancels_and_keeps_what_is_done(self):
        output = self.folder / "results"
        script = INTERRUPTED.format(path=[*sys.path, str(REPOSITORY / "python" / "tests")], output=str(output))
        process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
        self.assertEqual(process.stdout.readline(), "ready\n")
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=120)
        self.assertEqual((out, process.returncode), ("interrupted\n", 0))
        results = stiction.load(output)
        self.assertEqual(len(results.select(scenario="scenario-1", outcome="passed")), 1)
        self.assertEqual(len(results.select(scenario="scenario-2", outcome="passed")), 0)


if __name__ == "__main__":
    unittest.main()
