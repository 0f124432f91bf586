"""The type stub of the native module against the module, and the types and style of the package."""

import ast
import inspect
import subprocess
import sys
import unittest

from support import PACKAGE, REPOSITORY, need, stiction

# Names that every class or module of PyO3 has.
COMMON = {name for name in dir(object)} | {"__module__", "__weakref__", "__dict__"}


def public(names):
    """Names without those that are private or common to all classes."""
    special = {"__len__", "__arrow_c_stream__", "__new__"}
    return {name for name in names if name in special or not name.startswith("_")}


class Stub(unittest.TestCase):
    def setUp(self):
        self.tree = ast.parse((PACKAGE / "_native.pyi").read_text())

    def members(self, body):
        """Names that a stub declares, with their nodes."""
        found = {}
        for node in body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                found[node.name] = node
            elif isinstance(node, ast.AnnAssign) and getattr(node.annotation, "id", "") != "TypeAlias":
                found[node.target.id] = node
        return found

    def test_names_of_the_module(self):
        declared = self.members(self.tree.body)
        self.assertEqual(public(dir(stiction._native)), public(declared))

    def test_members_of_classes(self):
        for node in self.tree.body:
            if isinstance(node, ast.ClassDef):
                with self.subTest(node.name):
                    declared = public(self.members(node.body)) - {"__new__"}
                    found = public(set(dir(getattr(stiction._native, node.name))) - COMMON)
                    if node.name == "TaskContext":
                        # What a task reads depends on its needs: attributes without descriptors.
                        self.assertLessEqual(found, declared)
                    else:
                        self.assertEqual(found, declared)

    def test_parameters(self):
        for function in [node for node in self.tree.body if isinstance(node, ast.FunctionDef)]:
            declared = [argument.arg for argument in function.args.args]
            found = list(inspect.signature(getattr(stiction._native, function.name)).parameters)
            self.assertEqual(declared, found, function.name)
        for node in [node for node in self.tree.body if isinstance(node, ast.ClassDef)]:
            for method in [member for member in node.body if isinstance(member, ast.FunctionDef)]:
                is_property = any(getattr(mark, "id", "") == "property" for mark in method.decorator_list)
                if is_property or method.name.startswith("__"):
                    continue
                declared = [argument.arg for argument in method.args.args]
                found = list(inspect.signature(getattr(getattr(stiction._native, node.name), method.name)).parameters)
                self.assertEqual(declared, found, f"{node.name}.{method.name}")

    def test_everything_public_has_a_docstring(self):
        for name in stiction.__all__:
            if name != "__version__":
                self.assertTrue(inspect.getdoc(getattr(stiction, name)), name)


class Tools(unittest.TestCase):
    def run_tool(self, *arguments):
        """Runs a tool on the package."""
        call = [sys.executable, "-m", *arguments]
        done = subprocess.run(call, cwd=REPOSITORY / "python", capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_types(self):
        need("mypy", "types of the Python package")
        self.run_tool("mypy", "--strict", "--no-incremental", "--cache-dir", "/dev/null", "stiction")

    def test_style(self):
        need("ruff", "style of the Python package")
        self.run_tool("ruff", "check", "--no-cache", ".")


if __name__ == "__main__":
    unittest.main()
