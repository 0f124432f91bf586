"""The steps of action.yml, one after the other as GitHub runs them."""

import re
import unittest

from support import ROOT, RUNNER, Case, cells, scenario, skip

try:
    import yaml
except ImportError:
    yaml = None


class Action(Case):
    def setUp(self):
        super().setUp()
        if yaml is None:
            skip("the action: PyYAML is not installed")

    def use(self, **inputs):
        """Exit code, outputs, summary."""
        action = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
        values = {name: str(given.get("default", "")) for name, given in action["inputs"].items()}
        values.update({name.replace("_", "-"): value for name, value in inputs.items()})
        steps = {}

        def evaluate(text):
            """The expressions that the action has. Those of the version are left, as nothing is downloaded."""
            text = re.sub(r"\$\{\{ inputs\.([\w-]+) \}\}", lambda match: values[match[1]], text)
            output = r"\$\{\{ steps\.(\w+)\.outputs\.([\w-]+) \}\}"
            return re.sub(output, lambda match: steps[match[1]].outputs.get(match[2], ""), text)

        for step in action["runs"]["steps"]:
            environment = self.environment(True, {})
            environment.update({name: evaluate(value) for name, value in step["env"].items()})
            environment["GITHUB_ACTION_PATH"] = str(ROOT)
            command = ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", "-c", step["run"]]
            last = steps[step["id"]] = self.execute(command, environment)
            if last.code:
                break
        return last, {name: evaluate(output["value"]) for name, output in action["outputs"].items() if len(steps) > 1}

    def test_pass(self):
        self.write("my scenarios/a b.toml", scenario())
        last, outputs = self.use(runner=RUNNER, scenarios="my scenarios\n", arguments="--no-timing\n--strict\n")
        self.assertEqual(last.code, 0, last.stderr)
        self.assertEqual((outputs["exit-code"], outputs["failed-runs"], outputs["changed"]), ("0", "0", ""))
        self.assertEqual((outputs["runner"], outputs["junit"]), (RUNNER, "results/junit.xml"))

    def test_failure_against_a_baseline(self):
        self.write("a.toml", scenario())
        self.assertEqual(self.use(runner=RUNNER, scenarios="a.toml", output="before")[0].code, 0)
        inputs = {"set": "floor.friction=0.4", "jobs": "1", "compare_arguments": "--threshold steps=inf"}
        last, outputs = self.use(runner=RUNNER, scenarios="*.toml", baseline="before", **inputs)
        self.assertEqual((last.code, outputs["exit-code"], outputs["failed-runs"]), (1, "1", "1"), last.stderr)
        self.assertGreater(int(outputs["changed"]), 1)
        self.assertIn(["`a`", "`final_base_x`", "0.407747", "0.509684", "+0.102", "+25 %"], cells(last.summary, "`a`"))

    def test_missing_program(self):
        last, outputs = self.use(runner="none", scenarios="a.toml")
        self.assertEqual((last.code, outputs), (2, {}))


if __name__ == "__main__":
    unittest.main()
