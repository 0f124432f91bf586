"""Workflows, action, template, Dockerfile and snippets: they parse, and refer to files that exist."""

import re
import shutil
import subprocess
import unittest

from support import ROOT, need_program, skip

try:
    import yaml
except ImportError:
    yaml = None

FILES = ["action.yml", "ci/gitlab.yml", ".github/workflows/ci.yml", ".github/workflows/release.yml"]


def snippets():
    """The YAML of docs/ci.md."""
    page = (ROOT / "docs/ci.md").read_text(encoding="utf-8")
    return re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)


class Yaml(unittest.TestCase):
    def setUp(self):
        if yaml is None:
            skip("YAML files: PyYAML is not installed")

    def load(self, name):
        return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))

    def test_all_parse(self):
        for name in FILES:
            self.assertIsInstance(self.load(name), dict, name)
        self.assertGreaterEqual(len(snippets()), 2)
        for snippet in snippets():
            self.assertIsInstance(yaml.safe_load(snippet), dict, snippet)

    def test_steps_of_the_action(self):
        action = self.load("action.yml")
        run = (ROOT / "ci/run.sh").read_text(encoding="utf-8")
        for step in action["runs"]["steps"]:
            self.assertNotIn("${{", step["run"], "text of an input in a script is executed")
        used = set(re.findall(r"inputs\.([\w-]+)", str(action["runs"])))
        self.assertEqual(used, set(action["inputs"]))
        given = set(action["runs"]["steps"][1]["env"])
        self.assertEqual(given, set(re.findall(r"^#   (STICTION_\w+)", run, re.MULTILINE)))
        for name, output in action["outputs"].items():
            step = re.fullmatch(r"\$\{\{ steps\.(run|install)\.outputs\.([\w-]+) \}\}", output["value"])
            self.assertEqual(step[2], name)

    def test_snippets_use_inputs_that_exist(self):
        inputs = set(self.load("action.yml")["inputs"])
        variables = set(re.findall(r"STICTION_\w+", (ROOT / "ci/run.sh").read_text(encoding="utf-8")))
        variables |= set(self.load("ci/gitlab.yml")[".stiction"]["variables"])
        seen = 0
        for snippet in snippets():
            for job in yaml.safe_load(snippet).get("jobs", {}).values():
                for step in job["steps"]:
                    if "stiction@" in step.get("uses", ""):
                        self.assertLessEqual(set(step["with"]), inputs)
                        seen += 1
            self.assertLessEqual(set(re.findall(r"STICTION_\w+", snippet)), variables)
        self.assertGreater(seen, 0)

    def test_workflows_have_least_rights(self):
        for name in (".github/workflows/ci.yml", ".github/workflows/release.yml"):
            workflow = self.load(name)
            self.assertEqual(workflow["permissions"], {"contents": "read"})
            rights = {key: job["permissions"] for key, job in workflow["jobs"].items() if "permissions" in job}
            expected = {"release": {"contents": "write"}, "pypi": {"id-token": "write"}} if "release" in name else {}
            self.assertEqual(rights, expected)
            text = (ROOT / name).read_text(encoding="utf-8")
            self.assertNotIn("secrets.", text)
            for used in re.findall(r"uses: (\S+)", text):
                self.assertRegex(used, r"^\./|@(v\d+|release/v\d+|[0-9a-f]{40})$")

    def test_no_text_of_events_in_scripts(self):
        for name in (".github/workflows/ci.yml", ".github/workflows/release.yml"):
            for job in self.load(name)["jobs"].values():
                for step in job.get("steps", []):
                    self.assertNotIn("${{", step.get("run", ""))


class References(unittest.TestCase):
    def test_scripts_exist(self):
        for name in [*FILES, "Dockerfile", "ci/package.sh", ".ci/run"]:
            text = (ROOT / name).read_text(encoding="utf-8")
            # `$folder/$name/ci/run.sh` is the one of an archive, which has the same name.
            for path in re.findall(r"(?<![\w.])(\.?ci/[\w/]+\.(?:sh|py)|\.ci/run)", text):
                self.assertTrue((ROOT / path).is_file(), f"{name}: {path}")

    def test_copied_files_are_in_the_context(self):
        """Those of the Dockerfile exist, and .dockerignore lets them through."""
        kept = [line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")]
        members = re.search(r"members = \[(.*)\]", (ROOT / "Cargo.toml").read_text())[1]
        for member in re.findall(r'"([^"]+)"', members):
            self.assertIn(member, kept, "a crate that the build needs")
        for line in (ROOT / "Dockerfile").read_text().splitlines():
            if line.startswith("COPY ") and "--from" not in line and line != "COPY . .":
                for source in line.split()[1:-1]:
                    self.assertTrue((ROOT / source).exists(), source)
                    self.assertTrue(any((source + "/").startswith(name.rstrip("*")) for name in kept), source)

    def test_scripts_are_executable_and_parse(self):
        need_program("bash")
        for path in sorted((ROOT / "ci").glob("*.sh")):
            self.assertTrue(path.stat().st_mode & 0o100, path)
            subprocess.run(["bash", "-n", str(path)], check=True)

    def test_shellcheck(self):
        if shutil.which("shellcheck") is None:
            skip("shellcheck is not installed")
        subprocess.run(["shellcheck", *map(str, sorted((ROOT / "ci").glob("*.sh")))], check=True)


if __name__ == "__main__":
    unittest.main()
