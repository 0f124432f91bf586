"""The import of the package, or why it is not there: the one test that always runs."""

import importlib
import subprocess
import sys
import unittest


class Import(unittest.TestCase):
    def setUp(self):
        # Skips the test, not the module, so that a test has run where the package is missing.
        self.stiction = importlib.import_module("support").stiction

    def test_only_numpy_is_imported(self):
        script = f"import sys; sys.path[:0] = {sys.path!r}; import stiction; print(*sys.modules)"
        call = [sys.executable, "-c", script]
        loaded = subprocess.run(call, capture_output=True, text=True, check=True).stdout.split()
        for module in ("pandas", "polars", "pyarrow", "tqdm", "IPython", "matplotlib"):
            self.assertNotIn(module, loaded)
        self.assertIn("stiction._native", loaded)

    def test_folders(self):
        self.assertTrue((self.stiction.robots() / "hoap2" / "hoap2.toml").is_file())
        self.assertTrue((self.stiction.scenarios() / "sliding-block.toml").is_file())


if __name__ == "__main__":
    unittest.main()
