"""Stepping: closed forms, the bits of `run`, commands, contacts, saved states, logs."""

import pickle
import signal
import unittest

from support import SCENARIOS, FolderTest, block, counting, door, hoap2, numpy, stiction

GRAVITY = 9.81
# Moment of inertia of the door about its hinge, kg m^2 (robots/door/door.urdf).
DOOR = 1.0693333333333333 + 20.0 * 0.4**2


class Stepping(FolderTest):
    def test_sliding_block(self):
        simulation = stiction.Simulation(SCENARIOS / "sliding-block.toml")
        self.assertEqual((simulation.time, simulation.end, simulation.tick), (0.0, 1.0, 1e-3))
        self.assertEqual((simulation.joint_names, simulation.sole_names), ([], ["bottom"]))
        self.assertEqual((simulation.link_names, simulation.mass), (["block"], 1.0))
        self.assertTrue(simulation.advance_to(0.2))
        now = simulation.time
        self.assertGreaterEqual(now, 0.2)
        # The deceleration is constant: rounding dominates.
        self.assertAlmostEqual(simulation.state.base_position[0], 2.0 * now - 0.25 * GRAVITY * now**2, delta=1e-14)
        self.assertAlmostEqual(simulation.state.base_linear_velocity[0], 2.0 - 0.5 * GRAVITY * now, delta=1e-14)
        (contact,) = simulation.contacts
        self.assertEqual((contact.name, contact.state, contact.is_closed), ("bottom", "face-dynamic", True))
        self.assertEqual(contact.points.shape, (4, 3))
        self.assertTrue(contact.clamped.all())
        # Rounding of the sum of four forces.
        numpy.testing.assert_allclose(contact.forces.sum(axis=0), [-0.5 * GRAVITY, 0.0, GRAVITY], atol=1e-12)
        numpy.testing.assert_allclose(contact.velocities[:, 0], simulation.state.base_linear_velocity[0], atol=1e-14)
        self.assertEqual(simulation.run(), "passed")
        self.assertTrue(simulation.has_ended)
        self.assertFalse(simulation.step())
        self.assertEqual((simulation.outcome, simulation.message), ("passed", ""))
        # Rounding of the location of the stop.
        self.assertAlmostEqual(simulation.state.base_position[0], 4.0 / GRAVITY, delta=1e-12)
        (event,) = simulation.events
        self.assertEqual(event[1:3], ("stick", "bottom"))
        self.assertAlmostEqual(event[0], 4.0 / GRAVITY, delta=1e-12)
        energy = simulation.snapshot()["energy"]
        # All kinetic energy is lost to friction; rounding of 100 steps.
        self.assertAlmostEqual(energy["friction_loss"], 2.0, delta=1e-12)

    def test_control_ticks(self):
        simulation = stiction.Simulation(hoap2(control={"rate": 250.0}))
        self.assertEqual(simulation.tick, 4e-3)
        self.assertTrue(simulation.step())
        # Steps end at ticks to the last bits of the time.
        self.assertAlmostEqual(simulation.time, 4e-3, delta=1e-15)
        simulation.step(10)
        self.assertAlmostEqual(simulation.time, 44e-3, delta=1e-15)
        while simulation.step(20):
            pass
        self.assertEqual(simulation.time, 0.5)

    def test_single_steps(self):
        simulation = stiction.Simulation(block())
        times = [simulation.time]
        while simulation.step_once():
            times.append(simulation.time)
        self.assertEqual(simulation.time, 0.1)
        self.assertTrue(all(step > 0 for step in numpy.diff(times)))
        # One step of the integrator is at most max_step long.
        self.assertLessEqual(max(numpy.diff(times)), 0.01 + 1e-15)

    def test_bits_of_run(self):
        push = {"type": "push", "link": "torso", "force": [15, 5, 0], "start": 0.1, "duration": 0.1}
        for values in (
            stiction.Scenario(SCENARIOS / "sliding-block.toml"),
            stiction.Scenario(SCENARIOS / "drop-tilted.toml", set={"duration": 0.6, "expect": []}),
            stiction.Scenario(hoap2(force=[push])),
            stiction.Scenario(SCENARIOS / "hoap2-walk.toml", set={"duration": 0.5, "expect": [], "log.rate": 100.0}),
        ):
            (run, *_) = stiction.run(values, progress=False)
            with self.subTest(run.scenario):
                simulation = values.simulation()
                self.assertEqual(simulation.key, run.key)
                self.assertEqual(simulation.run(), run.outcome)
                for name, value in simulation.metrics.items():
                    # A run with a log evaluates the state once more for each row of it.
                    if name != "evaluations":
                        self.assertEqual(value, run.metrics[name], name)
                last = run.series(["base_?_m", "base_q?"])
                names = ("base_x_m", "base_y_m", "base_z_m")
                numpy.testing.assert_array_equal(simulation.state.base_position, [last[name][-1] for name in names])
                names = ("base_qx", "base_qy", "base_qz", "base_qw")
                numpy.testing.assert_array_equal(simulation.state.base_orientation, [last[name][-1] for name in names])
                logged = [(event.kind, event.subject, event.message) for event in run.events]
                self.assertEqual([event[1:] for event in simulation.events], logged)

    def test_ticks_do_not_change_the_bits(self):
        # Steps end at ticks in all of these: `control.idle_ticks`.
        whole = stiction.Simulation(hoap2())
        whole.run()
        stepped = stiction.Simulation(hoap2())
        while stepped.step(7):
            stepped.snapshot(), stepped.contacts, stepped.state
        self.assert_same_bits(whole.state, stepped.state)
        self.assertEqual(whole.metrics, stepped.metrics)

    def test_a_run_of_a_sweep_and_set(self):
        scenario = stiction.Scenario(block(sweep={"grid": {"floor.friction": [0.2, 0.4]}}))
        keys = [run.key for run in scenario.with_set({"duration": 0.05}).runs()]
        for index, friction in enumerate((0.2, 0.4)):
            simulation = scenario.simulation(index, set={"duration": 0.05})
            self.assertEqual(simulation.key, keys[index])
            simulation.run()
            # Rounding of some steps.
            velocity = 1.0 - friction * GRAVITY * 0.05
            self.assertAlmostEqual(simulation.state.base_linear_velocity[0], velocity, delta=1e-14)

    def test_an_early_end(self):
        values = hoap2(stop={"fallen": {"below": 1.0}})
        simulation = stiction.Simulation(values)
        with self.assertRaises(stiction.RunError) as caught:
            simulation.step(100)
        self.assertEqual(caught.exception.outcome, "fallen")
        self.assertEqual(caught.exception.time, simulation.time)
        self.assertEqual((simulation.has_ended, simulation.outcome), (True, "fallen"))
        self.assertIn("above the floor", simulation.message)
        with self.assertRaises(stiction.RunError):
            simulation.step()
        self.assertEqual(stiction.Simulation(values).run(), "fallen")

    def test_a_log(self):
        path = self.folder / "log.mcap"
        simulation = stiction.Simulation(SCENARIOS / "sliding-block.toml", log=path)
        simulation.run()
        (run,) = stiction.run(SCENARIOS / "sliding-block.toml", progress=False)
        self.assertEqual(path.read_bytes(), run.log.read_bytes())
        logged = stiction.Simulation(block(), log=self.folder / "other.mcap")
        with self.assertRaisesRegex(stiction.RunError, "writes a log"):
            logged.restore(logged.save())

    def test_pickling_is_refused(self):
        simulation = stiction.Simulation(block())
        with self.assertRaisesRegex(TypeError, "pickle its Scenario"):
            pickle.dumps(simulation)
        with self.assertRaisesRegex(TypeError, "pickle"):
            pickle.dumps(stiction.Batch([simulation]))


class Commands(FolderTest):
    def test_effort_on_a_hinge(self):
        simulation = stiction.Simulation(door())
        simulation.command(effort=[2.0])
        simulation.step(500)
        # q = tau t^2 / (2 I): a constant acceleration, so rounding of 500 steps dominates.
        self.assertAlmostEqual(simulation.state.q[0], 0.5 * 2.0 / DOOR * 0.5**2, delta=1e-14)
        simulation.command(effort=numpy.array([-2.0]))
        simulation.step(500)
        # The same impulse the other way: at rest after twice the way.
        self.assertAlmostEqual(simulation.state.qd[0], 0.0, delta=1e-14)
        self.assertAlmostEqual(simulation.state.q[0], 2.0 / DOOR * 0.5**2, delta=1e-14)
        numpy.testing.assert_array_equal(simulation.state.effort, [-2.0])

    def test_closed_loop(self):
        # Computed in Python at each tick: effort = -k q - d qd, at the ticks of a discrete system.
        simulation = stiction.Simulation(door(robot={**door()["robot"], "posture": {"hinge": 0.5}}))
        stiffness, damping, tick = 40.0, 20.0, 1e-3
        q, qd = 0.5, 0.0
        for _ in range(400):
            state = simulation.state
            simulation.command(effort=-stiffness * state.q - damping * state.qd)
            simulation.step()
            acceleration = (-stiffness * q - damping * qd) / DOOR
            q, qd = q + qd * tick + 0.5 * acceleration * tick**2, qd + acceleration * tick
        # Rounding of 400 steps; a tick of delay would be an error of 1e-3.
        self.assertAlmostEqual(simulation.state.q[0], q, delta=1e-13)
        self.assertAlmostEqual(simulation.state.qd[0], qd, delta=1e-13)

    def test_positions_modes_and_gains(self):
        simulation = stiction.Simulation(door(duration=10.0))
        simulation.command(position=[0.3], kp=[400.0], kd=[150.0], mode="position")
        simulation.step(5000)
        # The slowest part of the motion decays with exp(-2.9 t).
        self.assertAlmostEqual(simulation.state.q[0], 0.3, delta=1e-6)
        simulation.command(position=[0.5], velocity=[0.0], mode=["kinematic"])
        simulation.step(10)
        # A kinematic joint follows its command exactly.
        self.assertAlmostEqual(simulation.state.q[0], 0.5, delta=1e-15)

    def test_wrong_commands(self):
        simulation = stiction.Simulation(door())
        with self.assertRaisesRegex(ValueError, "effort: found 2 numbers, expected 1"):
            simulation.command(effort=[1.0, 2.0])
        with self.assertRaisesRegex(ValueError, "mode: found \"torque\""):
            simulation.command(mode="torque")
        with self.assertRaises(ValueError):
            simulation.command(position=["a"])


class SavedStates(FolderTest):
    def test_equal_bits_after_restore(self):
        push = {"type": "push", "link": "torso", "force": [20, 8, 0], "start": 0.15, "duration": 0.1}
        simulation = stiction.Simulation(hoap2(force=[push]))
        simulation.step(120)
        saved = simulation.save()
        self.assertEqual(saved.time, simulation.time)
        before = simulation.state
        simulation.step(200)
        first, metrics, events = simulation.state, simulation.metrics, simulation.events
        simulation.restore(saved)
        self.assert_same_bits(simulation.state, before)
        self.assertEqual(simulation.events, [event for event in events if event[0] <= saved.time])
        simulation.step(200)
        self.assert_same_bits(simulation.state, first)
        # Metrics of the end are NaN, which this takes as equal.
        numpy.testing.assert_equal(simulation.metrics, metrics)
        self.assertEqual(simulation.events, events)
        # Also in another simulation of the same run, and from there as often as one likes.
        other = stiction.Simulation(hoap2(force=[push]))
        other.restore(saved)
        other.step(200)
        self.assert_same_bits(other.state, first)

    def test_the_start_and_the_end(self):
        simulation = stiction.Simulation(block(control={"idle_ticks": True}))
        start = simulation.save()
        simulation.run()
        end, last = simulation.save(), simulation.state
        simulation.restore(start)
        self.assertEqual((simulation.time, simulation.has_ended), (0.0, False))
        simulation.run()
        self.assert_same_bits(simulation.state, last)
        simulation.restore(start)
        simulation.restore(end)
        self.assertTrue(simulation.has_ended)
        self.assert_same_bits(simulation.state, last)

    def test_refusals(self):
        saved = stiction.Simulation(block()).save()
        with self.assertRaisesRegex(stiction.RunError, "another run"):
            stiction.Simulation(block(duration=0.2)).restore(saved)
        walking = stiction.Simulation(SCENARIOS / "hoap2-walk.toml")
        # It begins to walk at 0.2 s.
        walking.step(250)
        saved = walking.save()
        walking.step(10)
        with self.assertRaisesRegex(stiction.RunError, "task `walk` depends on its earlier calls"):
            walking.restore(saved)
        sensing = stiction.Simulation(SCENARIOS / "estimators.toml")
        sensing.step(10)
        with self.assertRaisesRegex(stiction.RunError, "sensors"):
            sensing.save()


class Threads(unittest.TestCase):
    def test_other_threads_run_while_it_steps(self):
        simulation = stiction.Simulation(hoap2(duration=4.0))
        with counting() as counted:
            before = counted[0]
            simulation.step(4000)
            after = counted[0]
        self.assertGreater(after, before)

    def test_ctrl_c_ends_a_run(self):
        def interrupt(context, _command):
            if context.time > 0.05 and not sent:
                sent.append(context.time)
                # Python code of signals is executed by the main thread, which waits for the run.
                signal.raise_signal(signal.SIGINT)

        for name, arguments in (("run", ()), ("advance_to", (30.0,))):
            with self.subTest(name):
                # It would last for seconds.
                sent = []
                simulation = stiction.Simulation(hoap2(duration=30.0), tasks=[interrupt])
                with self.assertRaises(KeyboardInterrupt):
                    getattr(simulation, name)(*arguments)
                self.assertEqual(simulation.outcome, "cancelled")
                self.assertLess(simulation.time, 30.0)

    def test_one_thread_at_a_time(self):
        errors = []

        def read(_context, _command):
            try:
                simulation.state.q.sum()
            except stiction.RunError as error:
                errors.append(str(error))

        simulation = stiction.Simulation(hoap2(), tasks=[read])
        simulation.step(2)
        self.assertEqual(len(errors), 2)
        self.assertIn("is being stepped", errors[0])


if __name__ == "__main__":
    unittest.main()
