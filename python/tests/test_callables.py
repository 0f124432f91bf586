"""Tasks and forces in Python: against scripts and built-in types, needs, and exceptions."""

import math
import traceback
import unittest

from support import SCENARIOS, FolderTest, block, door, hoap2, numpy, stiction

SWAY = """
local start

function run(robot)
    local t = robot.time - 0.1
    local joint = robot.joint.left_shoulder_roll
    if start == nil then
        start = robot.desired.position[joint]
    end
    robot.set_position(joint, start + 0.4 * t * t)
    robot.set_velocity(joint, 0.8 * t)
    if t >= 0.3 then
        return "done"
    end
end
"""

FORCE = """
links = { "torso" }

function run(robot)
    local p, v = robot.link.torso.position, robot.link.torso.linear_velocity
    local x = -40 * (p[1] - 0.02) - 3 * v[1]
    local y = 5 * robot.time - 3 * v[2]
    return { { link = "torso", force = { x, y, 0 }, moment = { 0, 0, 0.1 } } }
end
"""


class Tasks(FolderTest):
    def test_bits_of_a_script(self):
        path = self.write("sway.luau", SWAY)
        scripted = stiction.Simulation(hoap2(task=[{"type": "script", "file": path, "start": 0.1}]))
        joint = scripted.joint_names.index("left_shoulder_roll")
        home = []

        def sway(context, command):
            t = context.time - 0.1
            if not home:
                home.append(command.position[joint])
            command.position[joint] = home[0] + 0.4 * t * t
            command.velocity[joint] = 0.8 * t
            return t < 0.3

        simulation = stiction.Simulation(hoap2(), tasks=[stiction.Task(sway, start=0.1)])
        # A script ends with the velocity that it commanded last, as a task in Python does.
        for _ in range(50):
            scripted.step(10), simulation.step(10)
            self.assert_same_bits(simulation.state, scripted.state)
        self.assertEqual(
            [event[0] for event in simulation.events if event[1] == "task"],
            [event[0] for event in scripted.events if event[1] == "task"],
        )
        self.assertIn("sway", {event[2] for event in simulation.events})

    def test_a_sine(self):
        joints = {"head_pan": {"amplitude": 0.1, "frequency": 1.5}}
        built_in = stiction.Simulation(hoap2(task=[{"type": "sine", "ramp": 0.0, "joints": joints}]))
        joint = built_in.joint_names.index("head_pan")
        home = stiction.Simulation(hoap2()).state.q[joint]

        def sine(context, command):
            phase = 2 * math.pi * 1.5 * context.time
            command.position[joint] = home + 0.1 * math.sin(phase)
            command.velocity[joint] = 0.1 * 2 * math.pi * 1.5 * math.cos(phase)

        simulation = stiction.Simulation(hoap2(), tasks=[sine])
        built_in.run(), simulation.run()
        # Sines of two libraries differ in the last bit; the run amplifies that little.
        numpy.testing.assert_allclose(simulation.state.q, built_in.state.q, atol=1e-12)
        self.assertAlmostEqual(simulation.state.q[joint], home + 0.1 * math.sin(1.5 * math.pi), delta=0.02)

    def test_what_a_task_reads(self):
        found = []

        def read(context, command):
            found.append(
                (
                    context.time,
                    context.start,
                    context.q.copy(),
                    context.base_position,
                    context.base_orientation,
                    context.com,
                    context.com_jacobian,
                    context.mass_matrix,
                    context.zmp,
                    context.link_poses["torso"],
                    list(command.mode),
                    command.kp.copy(),
                )
            )

        needs = ("com", "com_velocity", "com_jacobian", "mass_matrix", "zmp", "link_poses", "bias", "gravity_effort")
        simulation = stiction.Simulation(hoap2(), tasks=[stiction.Task(read, name="reader", start=0.2, needs=needs)])
        simulation.step(200)
        self.assertEqual(found, [])
        expected, com = simulation.state, simulation.snapshot()["com"]
        simulation.step()
        time, start, q, position, orientation, mass_centre, jacobian, mass, zmp, (link, turn), mode, kp = found[0]
        # Ticks are multiples of the tick to the last bits.
        self.assertAlmostEqual(time, 0.2, delta=1e-12)
        self.assertAlmostEqual(start, 0.2, delta=1e-12)
        numpy.testing.assert_array_equal(q, expected.q)
        numpy.testing.assert_array_equal(position, expected.base_position)
        numpy.testing.assert_array_equal(orientation, expected.base_orientation)
        # The same quantity by two ways: rounding.
        numpy.testing.assert_allclose(mass_centre, com, atol=1e-15)
        n = len(simulation.joint_names)
        self.assertEqual((jacobian.shape, mass.shape), ((3, n + 6), (n + 6, n + 6)))
        numpy.testing.assert_allclose(jacobian[:, :3], numpy.eye(3), atol=1e-15)
        numpy.testing.assert_allclose(mass[:3, :3], simulation.mass * numpy.eye(3), atol=1e-12)
        numpy.testing.assert_allclose(mass, mass.T, atol=1e-15)
        # The robot stands: its zero-moment point is below the centre of mass; what is left of the sway dominates.
        numpy.testing.assert_allclose(zmp[:2], com[:2], atol=2e-3)
        self.assertEqual((link.shape, turn.shape, len(kp)), ((3,), (4,), n))
        self.assertEqual(set(mode), {"position"})

    def test_commands_of_the_caller_follow_tasks(self):
        def push(_context, command):
            command.effort[0] = 3.0

        simulation = stiction.Simulation(door(), tasks=[push])
        simulation.step(100)
        numpy.testing.assert_array_equal(simulation.state.effort, [3.0])
        simulation.command(effort=[1.0])
        simulation.step(100)
        numpy.testing.assert_array_equal(simulation.state.effort, [1.0])

    def test_modes(self):
        def hold(context, command):
            command.mode[0] = "kinematic"
            command.position[0] = 0.1 * context.time

        simulation = stiction.Simulation(door(), tasks=[hold])
        simulation.step(100)
        # One tick behind, at which the position was commanded.
        self.assertAlmostEqual(simulation.state.q[0], 0.01, delta=1e-3)

    def test_needs_that_are_not_named(self):
        def read(context, _command):
            return context.com[0] > 1e3

        simulation = stiction.Simulation(hoap2(), tasks=[read])
        with self.assertRaisesRegex(AttributeError, "does not need \"com\": name it in `needs`"):
            simulation.step()
        with self.assertRaisesRegex(ValueError, "needs: found \"mass\""):
            stiction.Simulation(hoap2(), tasks=[stiction.Task(read, needs=["mass"])])

    def test_wrong_values(self):
        def wrong(_context, command):
            command.mode[0] = "torque"

        with self.assertRaisesRegex(ValueError, "torque"):
            stiction.Simulation(door(), tasks=[wrong]).step()


class Forces(FolderTest):
    def test_bits_of_a_constant_force(self):
        force = {"type": "constant", "link": "torso", "point": [0.0, 0.02, 0.05], "force": [3.0, 1.0, -2.0]}
        built_in = stiction.Simulation(hoap2(force=[force]))
        called = stiction.Force(lambda _t, _p, _v: (3.0, 1.0, -2.0), "torso", point=(0.0, 0.02, 0.05))
        simulation = stiction.Simulation(hoap2(), forces=[called])
        built_in.run(), simulation.run()
        self.assert_same_bits(simulation.state, built_in.state)

    def test_bits_of_a_script(self):
        path = self.write("force.luau", FORCE)
        scripted = stiction.Simulation(hoap2(force=[{"type": "script", "file": path}]))

        def force(time, position, velocity):
            x = -40 * (position[0] - 0.02) - 3 * velocity[0]
            y = 5 * time - 3 * velocity[1]
            return [x, y, 0, 0, 0, 0.1]

        simulation = stiction.Simulation(hoap2(), forces=[stiction.Force(force, "torso")])
        scripted.run(), simulation.run()
        self.assert_same_bits(simulation.state, scripted.state)

    def test_orbit(self):
        # scenarios/script-orbit.toml: an ellipse around the origin with a period of 1 s.
        scenario = stiction.Scenario(SCENARIOS / "script-orbit.toml", set={"force": [], "expect": []})
        strength = 4 * math.pi**2

        def attractor(_time, position, _velocity):
            return -strength / numpy.linalg.norm(position) ** 3 * position

        simulation = stiction.Simulation(scenario, forces=[stiction.Force(attractor, "block")])
        simulation.run()
        # Phase errors of an integration at relative tolerance 1e-10 add up over the orbit.
        numpy.testing.assert_allclose(simulation.state.base_position, [0.5, 0.0, 0.0], atol=1e-6)

    def test_corners(self):
        def jump(time, _position, _velocity):
            return [4.0 if time >= 0.0371 else 0.0, 0.0, 0.0]

        values = block(floor={"friction": 0.0})
        simulation = stiction.Simulation(values, forces=[stiction.Force(jump, "block", corners=[0.0371])])
        simulation.run()
        # A step ends at the jump, so both parts are exact; the force at the jump itself is that after it.
        self.assertAlmostEqual(simulation.state.base_linear_velocity[0], 1.0 + 4.0 * (0.1 - 0.0371), delta=1e-12)

    def test_wrong_forces(self):
        with self.assertRaisesRegex(ValueError, "no link `torzo`; .*torso"):
            stiction.Simulation(hoap2(), forces=[stiction.Force(lambda *_: (0, 0, 0), "torzo")])
        simulation = stiction.Simulation(block(), forces=[stiction.Force(lambda *_: (0.0, 0.0), "block")])
        with self.assertRaisesRegex(ValueError, "found 2 numbers, expected a force of 3"):
            simulation.run()


class Exceptions(unittest.TestCase):
    def assert_raised(self, simulation, method, name):
        """Asserts that a method raises the exception of a function, with its traceback, and ends the run."""
        arguments = {"step": (100,), "advance_to": (0.2,), "run": ()}[method]
        try:
            getattr(simulation, method)(*arguments)
            self.fail("nothing was raised")
        except LookupError as error:
            # `assertRaises` would drop the traceback.
            self.assertEqual(error.args, ("no such foot", 7))
            self.assertEqual(traceback.extract_tb(error.__traceback__)[-1].name, name)
        self.assertTrue(simulation.has_ended)
        self.assertEqual(simulation.outcome, "error")
        with self.assertRaises(stiction.RunError):
            simulation.step()

    def test_of_tasks(self):
        def failing_task(context, _command):
            if context.time > 0.02:
                raise LookupError("no such foot", 7)

        for method in ("step", "advance_to", "run"):
            with self.subTest(method):
                simulation = stiction.Simulation(hoap2(), tasks=[failing_task])
                self.assert_raised(simulation, method, "failing_task")

    def test_of_forces(self):
        def failing_force(time, _position, _velocity):
            if time > 0.02:
                raise LookupError("no such foot", 7)
            return 0.0, 0.0, 0.0

        for method in ("step", "advance_to", "run"):
            with self.subTest(method):
                simulation = stiction.Simulation(hoap2(), forces=[stiction.Force(failing_force, "torso")])
                self.assert_raised(simulation, method, "failing_force")

    def test_in_a_batch(self):
        def failing_task(_context, _command):
            raise LookupError("no such foot", 7)

        whole, broken = stiction.Simulation(hoap2()), stiction.Simulation(hoap2(), tasks=[failing_task])
        batch = stiction.Batch([whole, broken])
        with self.assertRaises(LookupError) as caught:
            batch.step(10)
        self.assertEqual(caught.exception.args, ("no such foot", 7))
        self.assertEqual(batch.has_ended.tolist(), [False, True])
        batch.step(10)
        # The other one continues.
        self.assertAlmostEqual(whole.time, 0.02, delta=1e-12)


if __name__ == "__main__":
    unittest.main()
