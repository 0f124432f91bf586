"""install.sh and the template of GitLab, with an archive of package.sh."""

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from support import ROOT, RUNNER, Case, need_program, scenario, skip


class Given(Case):
    def test_path_becomes_absolute(self):
        shutil.copy(RUNNER, self.work / "my runner")
        step = self.step("install.sh", runner="./my runner")
        self.assertEqual(step.code, 0, step.stderr)
        self.assertTrue(os.path.isabs(step.outputs["runner"]))
        self.assertTrue(os.path.samefile(step.outputs["runner"], self.work / "my runner"))

    def test_missing_program(self):
        for name in ("none", "a\nrunner=b", "$(touch x)"):
            step = self.step("install.sh", runner=name)
            self.assertEqual((step.code, step.outputs), (2, {}))
            self.assertEqual(self.files(), [])

    def test_versions_and_repositories_are_checked(self):
        for given in (
            {"version": "../../other", "repository": "a/b"},
            {"version": "v1\nrunner=x", "repository": "a/b"},
            {"version": "$(touch x)", "repository": "a/b"},
            {"version": "v1", "repository": "a"},
            {"version": "v1", "repository": "a/b/../c"},
            {"version": "v1", "repository": "a/$(touch x)"},
        ):
            step = self.step("install.sh", **{"runner": "", **given})
            self.assertEqual((step.code, step.outputs), (2, {}), given)
            self.assertIn(" is no ", step.stderr)
            self.assertEqual(self.files(), [])


class Release(Case):
    """Archives are made once; each test has a copy."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        need_program("curl")
        need_program("cargo")
        if sys.platform != "linux" or platform.machine() not in ("x86_64", "aarch64"):
            skip("archives: the test is for Linux")
        target = f"{platform.machine()}-unknown-linux-gnu"
        cls.name = f"stiction-{target}"
        made = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, made)
        cls.made = Path(made, "archives")
        process = subprocess.run(
            ["bash", str(ROOT / "ci/package.sh"), target, RUNNER, str(cls.made)],
            env={**os.environ, "PYTHON": sys.executable, "CARGO_NET_OFFLINE": "true"},
            capture_output=True,
            encoding="utf-8",
        )
        if process.returncode and "offline" in process.stderr:
            skip("archives: the manifests of all dependencies are not there (cargo fetch)")
        if process.returncode:
            raise AssertionError(process.stderr)

    def setUp(self):
        super().setUp()
        releases = self.folder / "my releases"
        self.archives = releases / "download/v9.9.9"
        shutil.copytree(self.made, self.archives)
        # file:// in place of https://: the same requests.
        self.releases = releases.as_uri()

    def install(self, **given):
        return self.step("install.sh", **{"runner": "", "releases": self.releases, "version": "v9.9.9", **given})

    def test_archive_is_installed_and_runs(self):
        step = self.install()
        self.assertEqual(step.code, 0, step.stderr)
        folder = Path(step.outputs["runner"]).parent
        for name in ("LICENSE-MIT", "LICENSE-APACHE", "LICENSE-three.js", "ci/run.sh", "ci/summary.py"):
            self.assertTrue((folder / name).is_file(), name)
        licences = (folder / "LICENSES-dependencies.txt").read_text(encoding="utf-8")
        for name in ("luau0-src ", "zstd-sys ", "lz4-sys ", "nalgebra ", "GNU C library"):
            self.assertIn(name, licences)
        self.assertNotIn("proptest ", licences)
        self.assertNotIn("stiction-", licences)
        self.write("a.toml", scenario())
        self.assertEqual(self.run_step(runner=step.outputs["runner"]).code, 0)

    def test_latest(self):
        (self.archives.parents[1] / "latest").mkdir()
        (self.archives.parents[1] / "latest/download").symlink_to(self.archives)
        self.assertEqual(self.install(version="latest").code, 0)

    def test_damaged_archive(self):
        with open(self.archives / f"{self.name}.tar.gz", "ab") as archive:
            archive.write(b"x")
        step = self.install()
        self.assertEqual((step.code, step.outputs), (2, {}))
        self.assertIn("SHA-256", step.stderr)

    def test_given_hash(self):
        right = hashlib.sha256((self.archives / f"{self.name}.tar.gz").read_bytes()).hexdigest()
        (self.archives / f"{self.name}.tar.gz.sha256").write_text("not read", encoding="utf-8")
        self.assertEqual(self.install(sha256=right).code, 0)
        self.assertEqual(self.install(sha256="0" * 64).code, 2)
        self.assertEqual(self.install(sha256="").code, 2)

    def test_missing_release(self):
        step = self.install(version="v0.0.1")
        self.assertEqual((step.code, step.outputs), (2, {}))
        self.assertIn("cannot download", step.stderr)

    def test_gitlab_job(self):
        try:
            import yaml
        except ImportError:
            skip("the job of GitLab: PyYAML is not installed")
        job = yaml.safe_load((ROOT / "ci/gitlab.yml").read_text(encoding="utf-8"))[".stiction"]
        # GitLab joins the lines of `script` in one shell that ends at the first failure. Only the address is another.
        address = "https://github.com/$STICTION_REPOSITORY/releases"
        script = "set -eo pipefail\n" + "\n".join(job["script"])
        self.assertIn(address, script)
        script = script.replace(address, self.releases)
        self.write("scenarios/a.toml", scenario(friction=0.4))
        environment = {**self.environment(False, {}), **job["variables"], "STICTION_VERSION": "v9.9.9"}
        process = subprocess.run(
            ["bash", "-c", script],
            cwd=self.work,
            env=environment,
            capture_output=True,
            encoding="utf-8",
        )
        self.assertEqual(process.returncode, 1, process.stderr)
        self.assertTrue((self.work / job["artifacts"]["reports"]["junit"]).is_file())
        self.assertTrue((self.work / job["artifacts"]["paths"][0] / "summary.md").is_file())


if __name__ == "__main__":
    unittest.main()
