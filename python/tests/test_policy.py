"""Policies: linear laws against tasks in Python, the example, bits of threads and saved states, errors."""

import onnx_file
from support import SCENARIOS, FolderTest, door, numpy, skip, stiction

# Efforts -30 (q - 0.25) - 15 qd of the door.
LAW = ([[-30.0], [-15.0]], [7.5])
TERMS = [{"term": "joint-positions", "relative": False}, {"term": "joint-velocities"}]


class Policies(FolderTest):
    def setUp(self):
        super().setUp()
        self.law = self.folder / "law.onnx"
        self.law.write_bytes(onnx_file.affine(*LAW))
        try:
            stiction.Simulation(self.door())
        except stiction.ScenarioError as error:
            if "built without networks" not in str(error):
                raise
            skip("policies: the module was built without the feature `policy`")

    def door(self, file=None, **keys):
        """The door with a policy that commands its effort."""
        task = {"type": "policy", "file": file or self.law, "observations": TERMS, **keys}
        return door(task=[{"action": {"joints": ["*"], "mode": "force"}, **task}])

    def test_a_linear_law_gives_the_motion_of_a_task(self):
        def law(context, command):
            command.effort[0] = 7.5 - 30.0 * context.q[0] - 15.0 * context.qd[0]

        by_network = stiction.Simulation(self.door())
        by_task = stiction.Simulation(door(), tasks=[stiction.Task(law)])
        for _ in range(10):
            by_network.step(100), by_task.step(100)
            # Single precision of observations and efforts of some N m.
            self.assertAlmostEqual(by_network.state.q[0], by_task.state.q[0], delta=1e-7)
        self.assertGreater(by_network.state.q[0], 0.05)

    def test_the_action_is_held(self):
        efforts = []

        def record(context, command):
            efforts.append(float(command.effort[0]))

        simulation = stiction.Simulation(self.door(decimation=50), tasks=[stiction.Task(record)])
        simulation.step(199)
        changes = [k for k in range(1, len(efforts)) if efforts[k] != efforts[k - 1]]
        self.assertEqual(changes, [50, 100, 150])
        self.assertEqual(efforts[0], 7.5)

    def test_bits_of_saved_states(self):
        simulation = stiction.Simulation(self.door(decimation=7, history=1))
        simulation.step(123)
        saved = simulation.save()
        simulation.step(100)
        end = simulation.state
        simulation.restore(saved)
        simulation.step(100)
        self.assert_same_bits(simulation.state, end)

    def test_errors(self):
        message = "takes 2 numbers, the observations have 3: joint-positions 1, joint-velocities 1, height 1"
        with self.assertRaisesRegex(stiction.ScenarioError, message):
            stiction.Simulation(self.door(observations=[*TERMS, {"term": "height"}]))
        with self.assertRaisesRegex(stiction.ScenarioError, "it is no ONNX file"):
            stiction.Simulation(self.door(file=self.write("bad.onnx", "bad")))

    def test_the_example_stands(self):
        example = SCENARIOS / "policies" / "hoap2-stands.toml"
        one = stiction.run(example, jobs=1, progress=False)
        two = stiction.run(example, jobs=2, progress=False)
        self.assertEqual({run.outcome for run in one}, {"passed"})
        self.assertEqual(len(one), 9)
        for column in ("final_base_x", "final_base_z", "evaluations"):
            numpy.testing.assert_array_equal(one.summary[column], two.summary[column])
