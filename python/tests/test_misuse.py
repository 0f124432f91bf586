"""Values, functions and processes that a careful user would not have, and what is left after errors."""

import gc
import multiprocessing
import os
import signal
import sys
import threading
import unittest
import weakref
from contextlib import contextmanager

from support import ROBOTS, FolderTest, stiction
from support import numpy as np

BLOCK = {"duration": 0.2, "robot": {"model": ROBOTS / "block/block.toml"}}
DOOR = {"duration": 1.0, "robot": {"model": ROBOTS / "door/door.urdf", "joint_default": {"mode": "force"}}}
HOAP2 = {"duration": 30.0, "robot": {"model": ROBOTS / "hoap2/hoap2.toml"}}


def interrupt_once(sent, time=0.05):
    """Returns a task that sends Ctrl-C once."""

    def interrupt(context, _command):
        if context.time > time and not sent:
            sent.append(context.time)
            signal.raise_signal(signal.SIGINT)

    return interrupt


@contextmanager
def interrupted_while_stepping():
    """Sends Ctrl-C from another thread, which runs as soon as the lock of the interpreter is released."""
    stepping = threading.Event()

    def interrupt():
        stepping.wait()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    interval = sys.getswitchinterval()
    thread.start()
    # Threads only change where the lock is released on purpose, so that the signal comes within the step.
    sys.setswitchinterval(1000.0)
    try:
        stepping.set()
        yield
    finally:
        sys.setswitchinterval(interval)
        thread.join()


def run_again(folder, answers):
    """Runs a scenario in a forked process."""
    try:
        stiction.run(BLOCK, output=folder, progress=False)
        answers.put("ran")
    except stiction.ResultsError as error:
        answers.put(str(error))


class Values(FolderTest):
    def test_values_without_an_end(self):
        loop = {}
        loop["a"] = loop
        deep = [1.0]
        for _ in range(10_000):
            deep = [deep]
        for value in (loop, {"duration": deep}):
            with self.assertRaisesRegex(ValueError, "nested more than 64 levels"):
                stiction.Scenario(value)
        with self.assertRaisesRegex(ValueError, "nested more than 64 levels"):
            stiction.Simulation(BLOCK, set={"gravity": deep})

    def test_numbers_that_convert_to_themselves(self):
        self.assertIn("duration = 0.5", stiction.Scenario({**BLOCK, "duration": np.longdouble(0.5)}).text)

    def test_keys_with_line_breaks(self):
        with self.assertRaisesRegex(stiction.ScenarioError, "unknown key"):
            stiction.run({**BLOCK, "a\nb": 1}, progress=False)

    def test_arrays_in_set_of_several_scenarios(self):
        scenarios = [
            stiction.Scenario(BLOCK, name=name, set={"gravity": np.array([0, 0, -size])})
            for name, size in (("a", 9.0), ("b", 3.0))
        ]
        results = stiction.run(scenarios, progress=False)
        forces = results.summary["final_normal_force_N"]
        # The block has 1 kg; rounding.
        np.testing.assert_allclose(forces, [9.0, 3.0], rtol=1e-12)

    def test_numbers_that_are_not_finite(self):
        door = stiction.Simulation(DOOR)
        with self.assertRaisesRegex(ValueError, r"effort\[0\]: found NaN"):
            door.command(effort=[np.nan])

        def task(_context, command):
            command.position[0] = np.inf

        with self.assertRaisesRegex(ValueError, r"command.position\[0\]: found inf"):
            stiction.Simulation(DOOR, tasks=[task]).step()
        force = stiction.Force(lambda *_: [0.0, np.nan, 0.0], "block", name="wind")
        with self.assertRaisesRegex(ValueError, r"force `wind`\[1\]: found NaN"):
            stiction.Simulation(BLOCK, forces=[force]).run()
        with self.assertRaisesRegex(ValueError, r"point\[2\]"):
            stiction.Simulation(BLOCK, forces=[stiction.Force(lambda *_: [0, 0, 0], "block", point=(0, 0, np.nan))])
        batch = stiction.Batch([stiction.Simulation(DOOR) for _ in range(2)])
        batch.effort[1, 0] = np.nan
        with self.assertRaisesRegex(ValueError, r"effort\[1\]\[0\]: found NaN"):
            batch.step()

    def test_rates_and_times_of_series(self):
        run = next(iter(stiction.run(BLOCK, progress=False)))
        for rate in (-1.0, 0.0, np.nan):
            with self.assertRaisesRegex(ValueError, "rate: found"):
                run.series("base_x_m", rate=rate)
        with self.assertRaisesRegex(ValueError, "start: found NaN"):
            run.series("base_x_m", start=np.nan)

    def test_logs_replace_files_only(self):
        with self.assertRaisesRegex(ValueError, "is not a file"):
            stiction.Simulation(BLOCK, log=self.folder)
        with self.assertRaisesRegex(ValueError, "is not a file"):
            stiction.Simulation(BLOCK, log=os.devnull)

    def test_results_in_a_relative_folder(self):
        before = os.getcwd()
        try:
            os.chdir(self.folder)
            results = stiction.run(BLOCK, output="relative", progress=False)
        finally:
            os.chdir(before)
        self.assertGreater(len(next(iter(results)).series("base_x_m")), 1)


class Functions(unittest.TestCase):
    def test_functions_that_would_do_nothing(self):
        def generator(_context, _command):
            yield

        async def coroutine(_context, _command):
            pass

        for task in (generator, coroutine, 3, "nod"):
            with self.subTest(task), self.assertRaises(TypeError):
                stiction.Simulation(BLOCK, tasks=[task])
        with self.assertRaisesRegex(TypeError, "expected stiction.Force"):
            stiction.Simulation(BLOCK, forces=[lambda *_: [0, 0, 0]])
        with self.assertRaisesRegex(ValueError, "found the start"):
            stiction.Simulation(BLOCK, tasks=[stiction.Task(lambda *_: None, start=np.nan)])

    def test_a_task_that_refers_to_its_simulation_is_collected(self):
        class Environment:
            def __init__(self):
                self.simulation = stiction.Simulation(BLOCK, tasks=[self.task])
                self.simulation.step()

            def task(self, _context, _command):
                pass

        environment = weakref.ref(Environment())
        gc.collect()
        self.assertIsNone(environment())

    def test_a_task_that_refers_to_its_batch_is_collected(self):
        class Environment:
            def __init__(self):
                self.batch = stiction.Batch([stiction.Simulation(BLOCK, tasks=[self.task]) for _ in range(2)])
                self.batch.step()

            def task(self, _context, _command):
                pass

        environment = weakref.ref(Environment())
        gc.collect()
        self.assertIsNone(environment())

    def test_exceptions_of_a_batch_do_not_return(self):
        broken = [True]

        def force(time, _position, _velocity):
            if broken[0] and time > 0.005:
                raise ValueError("boom")
            return [0.0, 0.0, 0.0]

        simulations = [stiction.Simulation(BLOCK, forces=[stiction.Force(force, "block")]) for _ in range(3)]
        batch = stiction.Batch(simulations)
        batch.step()
        states = [simulation.save() for simulation in simulations]
        with self.assertRaisesRegex(ValueError, "boom"):
            batch.step(20)
        broken[0] = False
        for simulation, state in zip(simulations, states, strict=True):
            simulation.restore(state)
        batch.refresh()
        batch.step(20)
        np.testing.assert_allclose(batch.time, 0.021, rtol=1e-12)

    def test_states_of_other_functions_are_refused(self):
        def plain():
            return stiction.Simulation(BLOCK, forces=[stiction.Force(lambda *_: [1.0, 0, 0], "block")])

        first = plain()
        first.step(5)
        state = first.save()
        with self.assertRaisesRegex(stiction.RunError, "other Python functions"):
            plain().restore(state)

    def test_events_follow_a_state(self):
        drop = {**BLOCK, "robot": {**BLOCK["robot"], "base": {"position": [0, 0, 0.06]}}}
        first, other = stiction.Simulation(drop), stiction.Simulation(drop)
        first.step(100)
        other.step(1)
        other.restore(first.save())
        self.assertGreater(len(first.events), 0)
        self.assertEqual(other.events, first.events)


class Interruptions(unittest.TestCase):
    def test_a_step_ends_at_a_tick(self):
        simulation = stiction.Simulation(HOAP2)
        with self.assertRaises(KeyboardInterrupt), interrupted_while_stepping():
            simulation.step(20_000)
        self.assertLess(simulation.time, 20.0)
        # Further steps continue from there.
        time = simulation.time
        simulation.step()
        self.assertAlmostEqual(simulation.time, time + 0.001, delta=1e-12)

    def test_a_batch_ends_at_a_tick(self):
        batch = stiction.Batch([stiction.Simulation(HOAP2) for _ in range(2)])
        with self.assertRaises(KeyboardInterrupt), interrupted_while_stepping():
            batch.step(20_000)
        self.assertLess(batch.time.max(), 20.0)
        self.assertEqual(batch.time[0], batch.time[1])
        batch.step()

    def test_a_restored_run_goes_on(self):
        simulation = stiction.Simulation(HOAP2, tasks=[interrupt_once([])])
        simulation.step(10)
        state = simulation.save()
        with self.assertRaises(KeyboardInterrupt):
            simulation.advance_to(25.0)
        simulation.restore(state)
        self.assertTrue(simulation.step(10))
        self.assertAlmostEqual(simulation.time, 0.02, delta=1e-12)


@unittest.skipUnless("fork" in multiprocessing.get_all_start_methods(), "processes cannot be forked here")
class Forks(FolderTest):
    def test_a_forked_process_is_refused_instead_of_waiting(self):
        stiction.run(BLOCK, progress=False)
        context = multiprocessing.get_context("fork")
        answers = context.Queue()
        process = context.Process(target=run_again, args=(str(self.folder / "x"), answers))
        process.start()
        self.assertIn("forked", answers.get(timeout=60))
        process.join()


if __name__ == "__main__":
    unittest.main()
