"""The examples of the documentation: code blocks and the notebook are executed."""

import contextlib
import io
import json
import os
import re
import runpy
import sys
import unittest

from support import REPOSITORY, FolderTest, need

GUIDE = REPOSITORY / "docs" / "python.md"
PAGE = REPOSITORY / "python" / "README.md"
NOTEBOOK = REPOSITORY / "docs" / "notebooks" / "first-study.ipynb"


def code_of(path):
    """Python code of a page, each block at its lines of the page."""
    text = path.read_text()
    lines = [""] * text.count("\n")
    for found in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        start = text[: found.start()].count("\n") + 1
        block = found.group(1).splitlines()
        lines[start : start + len(block)] = block
    return "\n".join(lines)


class Pages(FolderTest):
    def execute(self, path):
        """Executes the blocks of a page in order, in a folder of its own; returns the names they define."""
        script = self.write(f"{path.stem}.py", code_of(path))
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                return runpy.run_path(str(script))
        finally:
            os.chdir(before)

    def test_guide(self):
        names = self.execute(GUIDE)
        self.assertTrue(names["results"].passed)
        self.assertTrue((self.folder / "results" / "summary.csv").is_file())

    def test_page_of_the_package(self):
        self.assertTrue(self.execute(PAGE)["results"].passed)

    def test_lines(self):
        for path in (GUIDE, PAGE):
            for number, line in enumerate(path.read_text().splitlines(), 1):
                self.assertLessEqual(len(line), 100, f"{path.name}:{number}")


class Notebook(FolderTest):
    def test_outputs_are_cleared(self):
        notebook = json.loads(NOTEBOOK.read_text())
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                self.assertEqual((cell["outputs"], cell["execution_count"]), ([], None))

    def test_execution(self):
        for module in ("nbclient", "nbformat", "ipykernel", "matplotlib", "polars"):
            need(module, "the notebook of the Python package")
        import nbclient
        import nbformat

        notebook = nbformat.read(NOTEBOOK, as_version=4)
        # The kernel starts with the interpreter and the path of this process.
        path = os.pathsep.join(entry for entry in sys.path if entry)
        environment = dict(os.environ, PYTHONPATH=path, MPLCONFIGDIR=str(self.folder))
        client = nbclient.NotebookClient(
            notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(self.folder)}}
        )
        client.create_kernel_manager()
        # The kernel specification may name another interpreter.
        client.km.kernel_spec.argv[0] = sys.executable
        client.execute(env=environment)
        outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
        pictures = [output for output in outputs if "image/png" in output.get("data", {})]
        self.assertEqual(len(pictures), 2)
        self.assertFalse([output for output in outputs if output.output_type == "error"])
        errors = "".join(output.text for output in outputs if output.get("name") == "stderr")
        self.assertNotIn("Warning", errors)


if __name__ == "__main__":
    unittest.main()
