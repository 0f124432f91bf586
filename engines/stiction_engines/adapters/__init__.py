"""Finds and loads adapters of engines.

Each file of this folder is an adapter, named after the file. The path of a Python file outside of it names an
adapter, too. An adapter cannot be loaded where its package is missing: `NotInstalled` says what to install.
"""

import ast
import importlib
import importlib.util
from pathlib import Path

from ..engine import Unsupported

FOLDER = Path(__file__).parent


class NotInstalled(Exception):
    """The package or program of an engine is missing."""


def names():
    """Names of the adapters of this folder."""
    return sorted(file.stem for file in FOLDER.glob("*.py") if not file.stem.startswith("_"))


def path(name):
    """The file of an adapter, by its name or by its own path."""
    return Path(name).resolve() if name.endswith(".py") else FOLDER / f"{name}.py"


def package(name):
    """What pip installs for an adapter: `package` of its class, read without importing it."""
    tree = ast.parse(path(name).read_text())
    adapter = next((n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "Adapter"), None)
    for node in adapter.body if adapter else []:
        targets = node.targets if isinstance(node, ast.Assign) else []
        if any(isinstance(target, ast.Name) and target.id == "package" for target in targets):
            return ast.literal_eval(node.value)
    return name


def load(name):
    """The engine of an adapter. Raises `NotInstalled`."""
    try:
        if name.endswith(".py"):
            spec = importlib.util.spec_from_file_location(path(name).stem, path(name))
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        else:
            module = importlib.import_module(f"{__name__}.{name}")
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("stiction_engines"):
            raise
        raise NotInstalled(f"not installed (pip install {package(name)})") from error
    engine = module.Adapter()
    try:
        engine.version()
    except Unsupported as error:
        raise NotInstalled(f"not installed ({error})") from error
    return engine
