"""Robots and example scenarios that come with the package."""

from __future__ import annotations

from pathlib import Path


def _folder(name: str) -> Path:
    package = Path(__file__).resolve().parent
    # In an installed package the folder is package data; in the repository it is in its root.
    for folder in (package / name, package.parents[1] / name):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the package has no folder {name!r}: {package / name}")


def robots() -> Path:
    """Returns the folder of the included robots, such as ``robots() / "hoap2/hoap2.toml"``."""
    return _folder("robots")


def scenarios() -> Path:
    """Returns the folder of the example scenarios, such as ``scenarios() / "sliding-block.toml"``."""
    return _folder("scenarios")
