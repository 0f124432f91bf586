"""Scenarios from files, dictionaries and TOML text."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from stiction import _native
from stiction._errors import Diagnostic, ScenarioError

if TYPE_CHECKING:
    from stiction._results import Results
    from stiction._simulation import Simulation

DEFAULT_NAME = "scenario"


@dataclass(frozen=True)
class PlannedRun:
    """A run that a scenario expands to.

    Attributes:
        scenario: Name of the scenario.
        key: Hash of everything that determines the result.
        label: What distinguishes the run from the others of its scenario; may be empty.
        seed: Seed.
        parameters: Swept parameters under their dotted names, in the order of the file.
    """

    scenario: str
    key: str
    label: str
    seed: int
    parameters: Mapping[str, object]


class Scenario:
    """A scenario: one run, or a sweep of many.

    Args:
        source: Path of a TOML file, or its content as a dictionary with the keys of a scenario file. Values are
            dictionaries, lists, tuples, strings, numbers, booleans, paths, and NumPy scalars and arrays. For TOML
            text use :meth:`parse`.
        name: Name of the scenario, under which its results are written. Default: the name of the file without
            ``.toml``, or ``"scenario"``.
        folder: Folder at which relative paths in the scenario start. Default: that of the file, or the working
            directory.
        set: Values by dotted key, as of ``--set``: ``{"floor.friction": 0.4, "force.0.force": [1, 0, 0]}``.

    Raises:
        ScenarioError: The file cannot be read or is not TOML. Keys and values are checked by :meth:`check`,
            :meth:`runs` and whatever runs the scenario.
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Mapping[str, object],
        *,
        name: str | None = None,
        folder: str | os.PathLike[str] | None = None,
        set: Mapping[str, object] | None = None,
    ) -> None:
        if isinstance(source, Mapping):
            self._file = _native.ScenarioFile.from_dict(_path(name or DEFAULT_NAME, folder), dict(source))
        elif isinstance(source, (str, os.PathLike)):
            self._file = _load(source, name, folder)
        else:
            raise TypeError(f"a scenario is a path or a dictionary, not {type(source).__name__}")
        self._set: dict[str, object] = dict(set or {})

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        name: str | None = None,
        folder: str | os.PathLike[str] | None = None,
        set: Mapping[str, object] | None = None,
    ) -> Scenario:
        """Reads a scenario from TOML text; arguments as of the class.

        Raises:
            ScenarioError: The text is not TOML.
        """
        return cls._of(_native.ScenarioFile.parse(_path(name or DEFAULT_NAME, folder), text), set or {})

    @classmethod
    def _of(cls, file: _native.ScenarioFile, values: Mapping[str, object]) -> Scenario:
        scenario = cls.__new__(cls)
        scenario._file = file
        scenario._set = dict(values)
        return scenario

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self._file.name

    @property
    def path(self) -> Path:
        """Path of the file in messages; of a dictionary or text it need not exist."""
        return Path(self._file.path)

    @property
    def text(self) -> str:
        """The scenario as TOML text, without the values of ``set``."""
        return self._file.text

    @property
    def values(self) -> Mapping[str, object]:
        """The values of ``set``."""
        return dict(self._set)

    def with_set(self, values: Mapping[str, object], *, name: str | None = None) -> Scenario:
        """Returns a copy with further values of ``set``; of a key given twice the last value counts.

        Args:
            values: Values by dotted key.
            name: Another name; two scenarios of one batch must differ in their names.
        """
        file = self._file
        if name is not None and name != self.name:
            file = _native.ScenarioFile.parse(_path(name, self.path.parent), file.text)
        return self._of(file, {**self._set, **values})

    def check(self, filter: str | None = None) -> list[Diagnostic]:
        """Checks the scenario and its robots, and expands its sweep. Does not raise for what it finds.

        Args:
            filter: Condition that selects runs, such as ``'floor.friction.static < 0.5'``.

        Returns:
            Errors, warnings and notes; none if all is well.
        """
        found = _native.check([self._file], list(self._set.items()), filter)
        return [Diagnostic.from_dict(entry) for entry in found]

    def runs(self, filter: str | None = None) -> list[PlannedRun]:
        """Returns the runs that the scenario expands to, in order.

        Args:
            filter: Condition that selects runs.

        Raises:
            ScenarioError: The scenario or the filter is invalid.
        """
        planned = _native.runs([self._file], list(self._set.items()), filter, None)
        fields = PlannedRun.__dataclass_fields__
        return [PlannedRun(**{name: entry[name] for name in fields}) for entry in planned]

    def run(self, **options: Any) -> Results:
        """Runs the scenario: :func:`stiction.run` with its options."""
        from stiction._execution import run

        return run(self, **options)

    def simulation(self, run: int = 0, **options: Any) -> Simulation:
        """Returns a run to be stepped: :class:`stiction.Simulation` with its options.

        Args:
            run: Index of the run among :meth:`runs`.
            **options: ``set``, ``tasks``, ``forces`` and ``log``.
        """
        from stiction._simulation import Simulation

        return Simulation(self, run=run, **options)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._file.path, self._file.text, self._set)

    def __repr__(self) -> str:
        values = f", set={self._set!r}" if self._set else ""
        return f"Scenario({str(self.path)!r}{values})"


ScenarioLike: TypeAlias = "str | os.PathLike[str] | Mapping[str, object] | Scenario"


def _path(name: str, folder: str | os.PathLike[str] | None) -> str:
    """Returns the path that gives a scenario its name and the start of its relative paths."""
    if not name or os.path.basename(name) != name:
        raise ValueError(f"the name of a scenario is that of a folder of results, not a path: {name!r}")
    return os.path.join(os.fspath(folder) if folder is not None else "", f"{name}.toml")


def _load(
    source: str | os.PathLike[str], name: str | None, folder: str | os.PathLike[str] | None
) -> _native.ScenarioFile:
    path = os.fspath(source)
    if "\n" in path:
        raise ValueError("a scenario is given by its path; for TOML text use stiction.Scenario.parse(text)")
    file = _native.ScenarioFile.load(path)
    if name is None and folder is None:
        return file
    start = folder if folder is not None else os.path.dirname(path)
    return _native.ScenarioFile.parse(_path(name or file.name, start), file.text)


def _restored(path: str, text: str, values: dict[str, object]) -> Scenario:
    """Rebuilds a pickled scenario."""
    return Scenario._of(_native.ScenarioFile.parse(path, text), values)


def scenario_of(source: ScenarioLike, *, folder: str | os.PathLike[str] | None = None) -> Scenario:
    """Returns a scenario as it is, or reads one from a path or dictionary.

    Args:
        source: The scenario.
        folder: Where relative paths of a dictionary start.
    """
    if isinstance(source, Scenario):
        return source
    return Scenario(source, folder=folder) if isinstance(source, Mapping) else Scenario(source)


def collect(
    sources: ScenarioLike | Iterable[ScenarioLike], folder: str | os.PathLike[str] | None
) -> list[Scenario]:
    """Returns the scenarios of a batch: files of folders in alphabetical order, several dictionaries numbered.

    Raises:
        ScenarioError: A file cannot be read, or the folders contain no scenario.
    """
    if isinstance(sources, (str, os.PathLike, Mapping, Scenario)):
        sources = [sources]
    found: list[Scenario] = []
    listed = list(sources)
    number = 0
    several = sum(isinstance(source, Mapping) for source in listed) > 1
    for source in listed:
        if isinstance(source, Mapping):
            number += 1
            found.append(Scenario(source, name=f"{DEFAULT_NAME}-{number}" if several else None, folder=folder))
        elif isinstance(source, (str, os.PathLike)) and os.path.isdir(source):
            found += [Scenario(path) for path in sorted(Path(source).glob("*.toml"))]
        else:
            found.append(scenario_of(source))
    if not found:
        folders = ", ".join(str(source) for source in listed)
        raise ScenarioError(f"no .toml file in {folders}" if folders else "no scenario is given")
    return found
