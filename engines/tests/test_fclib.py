"""Contact problems of the runner in FCLIB's format, and another solver that solves them."""

import contextlib
import importlib.util
import io
import subprocess
import tempfile
import unittest
from pathlib import Path

import support

from stiction_engines.adapters import stiction

ROOT = Path(__file__).resolve().parents[2]


class Falls(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.need("h5py", "tests of FCLIB's format")
        support.need("scipy", "tests of FCLIB's format")
        from stiction_engines import fclib, friction_problem

        cls.fclib, cls.problem = fclib, friction_problem
        try:
            program = stiction._program()
        except Exception as error:
            support.skip(f"tests of FCLIB's format: {error}")
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        scenario = ROOT / "scenarios/hoap2-falls.toml"
        changes = ["--set", "floor.friction=0.5", "--set", "duration=1.3", "--no-log", "--dump-problems=all"]
        output = Path(cls.folder.name) / "runs"
        # Its expectations are those of the whole scenario.
        subprocess.run([program, "run", scenario, *changes, "-o", output], capture_output=True)
        cls.printed = io.StringIO()
        with contextlib.redirect_stdout(cls.printed):
            cls.code = fclib.main([str(output), "-o", str(Path(cls.folder.name) / "fclib"), "--check"])
        cls.files = sorted((Path(cls.folder.name) / "fclib").rglob("*.hdf5"))

    def test_files_read_back_as_written(self):
        self.assertEqual(self.code, 0, self.printed.getvalue())
        self.assertGreaterEqual(len(self.files), 15, self.printed.getvalue())

    def test_layout(self):
        import h5py

        with h5py.File(self.files[0]) as file:
            local = file["fclib_local"]
            self.assertEqual(int(local["spacedim"][0]), 3)
            contacts = len(local["vectors/mu"])
            self.assertEqual(len(local["vectors/q"]), 3 * contacts)
            self.assertEqual((int(local["W/m"][0]), int(local["W/n"][0])), (3 * contacts, 3 * contacts))
            self.assertEqual(int(local["W/nz"][0]), -1)

    def test_stored_solutions_obey_the_laws(self):
        # The runner solves to 1e-9 of the load; sums of vertex forces round.
        for file in self.files:
            problem = self.fclib.read(file)
            if problem.solution:
                with self.subTest(file=file.name):
                    self.assertLess(max(self.problem.residuals(problem, *problem.solution)), 1e-8)

    def test_another_solver_finds_the_same_motion(self):
        if importlib.util.find_spec("pinocchio") is None:
            self.skipTest("pin is not installed")
        for file in self.files:
            problem = self.fclib.read(file)
            if problem.solution:
                r = self.problem.solve_pinocchio(problem)
                u = problem.W @ r + problem.q
                with self.subTest(file=file.name):
                    self.assertLess(max(self.problem.residuals(problem, u, r)), 1e-8)
                    # Pinocchio's accuracy: 9.7e-7 where its residual is 3e-9.
                    self.assertLess(self.fclib.relative_difference(problem, u), 1e-5)


if __name__ == "__main__":
    unittest.main()
