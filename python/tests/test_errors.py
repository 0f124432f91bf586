"""Errors: file, line, column, key and help of what is wrong in scenarios, values and robots."""

import pickle
import unittest

from support import SCENARIOS, FolderTest, block, stiction

FILE = """duration = 0.1

[robot]
model = "{robots}/block/block.toml"

[floor]
fricton = 0.3
"""


class Scenarios(FolderTest):
    def refused(self, call, message):
        """Asserts that a call raises a ScenarioError with a message; returns it."""
        with self.assertRaisesRegex(stiction.ScenarioError, message) as caught:
            call()
        return caught.exception

    def test_unknown_key_of_a_file(self):
        path = self.write("wrong.toml", FILE.format(robots=stiction.robots()))
        for call in (
            lambda: stiction.run(path, progress=False),
            lambda: stiction.Scenario(path).runs(),
            lambda: stiction.Simulation(path),
        ):
            error = self.refused(call, "unknown key `fricton`")
            self.assertEqual((error.file, error.line, error.column), (str(path), 7, 1))
            self.assertEqual((error.key, error.help), ("floor.fricton", "did you mean `friction`?"))
            self.assertIn("7 | fricton = 0.3", str(error))
            self.assertIsInstance(error, ValueError)
        (found,) = stiction.Scenario(path).check()
        self.assertEqual(found, error.diagnostics[0])
        self.assertEqual(found.severity, "error")
        self.assertIn("7 | fricton = 0.3", str(found))

    def test_unknown_key_of_a_dictionary(self):
        error = self.refused(lambda: stiction.run(block(floor={"fricton": 0.3})), "unknown key `fricton`")
        self.assertEqual((error.key, error.help), ("floor.fricton", "did you mean `friction`?"))
        self.assertEqual(error.file, "scenario.toml")
        # The line is that of the text of the scenario.
        text = stiction.Scenario(block(floor={"fricton": 0.3})).text
        self.assertEqual(text.splitlines()[error.line - 1][error.column - 1 :][:7], "fricton")

    def test_wrong_value_of_a_dictionary(self):
        error = self.refused(lambda: stiction.run(block(duration="long")), "duration")
        self.assertEqual(error.key, "duration")

    def test_values_of_other_types(self):
        with self.assertRaisesRegex(TypeError, r"robot\.base\[1\].*object"):
            stiction.Scenario({"robot": {"base": [1, object()]}})
        with self.assertRaisesRegex(TypeError, "floor.friction.*complex"):
            stiction.run(block(), set={"floor.friction": 1j})

    def test_unknown_key_of_set(self):
        error = self.refused(lambda: stiction.run(block(), set={"floor.fricton": 1.0}), "unknown key `fricton`")
        self.assertEqual((error.file, error.key), ("--set", "floor.fricton"))
        self.assertEqual(error.help, "did you mean `friction`?")
        own = stiction.Scenario(block(), set={"floor.fricton": 1.0})
        self.assertEqual(self.refused(own.runs, "unknown key").file, "--set")
        several = [own, stiction.Scenario(block(), name="other")]
        self.assertEqual(self.refused(lambda: stiction.run(several), "unknown key").file, "--set")

    def test_filters(self):
        error = self.refused(lambda: stiction.run(block(), filter="floor.friction <"), "")
        self.assertEqual(error.file, "--filter")
        self.refused(lambda: stiction.run(block(), filter='name == "other"'), "filter")

    def test_missing_files_and_empty_folders(self):
        path = self.folder / "none.toml"
        error = self.refused(lambda: stiction.run(path), "No such file|cannot read")
        self.assertEqual(error.file, str(path))
        self.refused(lambda: stiction.run(self.folder), "no .toml file in")
        self.refused(lambda: stiction.run([]), "no scenario")

    def test_no_toml(self):
        error = self.refused(lambda: stiction.Scenario.parse("duration =\n", name="broken"), "")
        self.assertEqual((error.file, error.line), ("broken.toml", 1))

    def test_no_such_run(self):
        with self.assertRaisesRegex(IndexError, "run: found 1, the scenario has 1 runs"):
            stiction.Simulation(block(), run=1)

    def test_too_many_runs(self):
        values = block(sweep={"repeat": 11})
        self.refused(lambda: stiction.run(values, max_runs=10), "11|10")

    def test_several_errors(self):
        error = self.refused(lambda: stiction.run(block(floor={"fricton": 0.3}, duration="long")), "unknown key")
        self.assertEqual({entry.key for entry in error.diagnostics}, {"floor.fricton", "duration"})

    def test_equal_names(self):
        scenarios = [stiction.Scenario(block()), stiction.Scenario(block(duration=0.2))]
        self.refused(lambda: stiction.run(scenarios), "both scenario `scenario`")

    def test_check_finds_nothing(self):
        self.assertEqual(stiction.Scenario(SCENARIOS / "sliding-block.toml").check(), [])

    def test_errors_are_pickled(self):
        error = self.refused(lambda: stiction.run(block(floor={"fricton": 0.3})), "")
        copy = pickle.loads(pickle.dumps(error))
        self.assertEqual((str(copy), copy.diagnostics, copy.line), (str(error), error.diagnostics, error.line))
        run = pickle.loads(pickle.dumps(stiction.RunError("diverged", "diverged", 0.5)))
        self.assertEqual((str(run), run.outcome, run.time), ("diverged", "diverged", 0.5))


class Robots(FolderTest):
    def test_broken_urdf(self):
        path = self.write("broken.urdf", '<robot name="broken">\n  <link nme="a"/>\n</robot>\n')
        with self.assertRaises(stiction.RobotError) as caught:
            stiction.run({"robot": {"model": path}})
        self.assertEqual(caught.exception.file, str(path))
        self.assertEqual(caught.exception.line, 2)

    def test_missing_robot(self):
        with self.assertRaisesRegex(stiction.ScenarioError, "none.toml"):
            stiction.run({"robot": {"model": self.folder / "none.toml"}})


if __name__ == "__main__":
    unittest.main()
