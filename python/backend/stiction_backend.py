"""Build backend of the package: maturin, with the files that lie outside of this folder.

Robots, example scenarios and licences are in the root of the repository. `stage` copies them here for a build. Source
packages contain robots and scenarios; maturin adds the licences to them. Before `maturin build` or `maturin sdist`
itself: `python3 backend/stiction_backend.py wheel` or `sdist`.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Hooks of maturin that need no copies.
__all__ = ["get_requires_for_build_editable", "get_requires_for_build_sdist", "get_requires_for_build_wheel"]

PYTHON = Path(__file__).resolve().parents[1]
ROOT = PYTHON.parent
DATA = {ROOT / name: PYTHON / "stiction" / name for name in ("robots", "scenarios")}
LICENCES = {ROOT / name: PYTHON / name for name in ("LICENSE-APACHE", "LICENSE-MIT")}


def stage(kind: str) -> list[Path]:
    """Copies the files of a ``wheel`` or ``sdist`` that are not here; returns the copies."""
    made: list[Path] = []
    if not (ROOT / "python" / "Cargo.toml").exists():
        # A source package, which has them.
        return made
    for source, copy in {**DATA, **(LICENCES if kind == "wheel" else {})}.items():
        if copy.exists() or not source.exists():
            continue
        made.append(copy)
        if source.is_dir():
            shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, copy)
    return made


@contextmanager
def staged(kind: str) -> Iterator[None]:
    """Removes the copies after a build."""
    made = stage(kind)
    try:
        yield
    finally:
        for copy in made:
            shutil.rmtree(copy) if copy.is_dir() else copy.unlink()


if __name__ == "__main__":
    stage(sys.argv[1])
else:
    import maturin
    from maturin import get_requires_for_build_editable, get_requires_for_build_sdist, get_requires_for_build_wheel

    def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]
        with staged("wheel"):
            return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)

    def build_sdist(sdist_directory, config_settings=None):  # type: ignore[no-untyped-def]
        with staged("sdist"):
            return maturin.build_sdist(sdist_directory, config_settings)

    def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):  # type: ignore[no-untyped-def]
        with staged("wheel"):
            return maturin.prepare_metadata_for_build_wheel(metadata_directory, config_settings)

    def build_editable(wheel_directory, config_settings=None, metadata_directory=None):  # type: ignore[no-untyped-def]
        # The package then finds robots and scenarios in the repository.
        return maturin.build_editable(wheel_directory, config_settings, metadata_directory)
