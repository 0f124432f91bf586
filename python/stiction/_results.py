"""Results of a batch: a folder with a summary, records and logs."""

from __future__ import annotations

import html
import json
import os
import shutil
import tempfile
import weakref
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction import _native
from stiction._errors import ResultsError
from stiction._log import Event
from stiction._run import Run
from stiction._table import Summary, cell_text, html_table

_SHOWN_RUNS = 10


def _remove(path: str, process: int) -> None:
    """Removes a temporary folder, in the process that made it: not in its forks."""
    if os.getpid() == process:
        shutil.rmtree(path, ignore_errors=True)


class ResultsFolder:
    """The folder of results; a temporary one is removed when nothing refers to it any more."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        self.is_temporary = False

    @classmethod
    def temporary(cls) -> ResultsFolder:
        """Makes a temporary folder."""
        folder = cls(tempfile.mkdtemp(prefix="stiction-"))
        folder.is_temporary = True
        weakref.finalize(folder, _remove, str(folder.path), os.getpid())
        return folder

    def __reduce__(self) -> tuple[Any, ...]:
        if self.is_temporary:
            raise TypeError("cannot pickle results in a temporary folder: run with output=FOLDER")
        return ResultsFolder, (str(self.path.resolve()),)


class Runs(Mapping[str, Run]):
    """The runs of results by key, in the order of the summary.

    Where two scenarios have a run of the same key, as equal files do, the keys here are ``"SCENARIO/KEY"``, which are
    valid for every run.
    """

    def __init__(self, folder: ResultsFolder, summary: Summary) -> None:
        self._folder = folder
        self._summary = summary

    @cached_property
    def _columns(self) -> dict[str, list[Any]]:
        # Columns are converted once, not once per run.
        return {name: self._summary[name].tolist() for name in self._summary.columns}

    @cached_property
    def _rows(self) -> dict[str, int]:
        count = Counter(self._columns["key"])
        pairs = zip(self._columns["scenario"], self._columns["key"], strict=True)
        return {key if count[key] == 1 else f"{scenario}/{key}": row for row, (scenario, key) in enumerate(pairs)}

    @cached_property
    def _qualified_rows(self) -> dict[str, int]:
        pairs = zip(self._columns["scenario"], self._columns["key"], strict=True)
        return {f"{scenario}/{key}": row for row, (scenario, key) in enumerate(pairs)}

    def __getitem__(self, key: str) -> Run:
        row = self._rows.get(key)
        if row is None:
            row = self._qualified_rows.get(key)
        if row is None:
            of_several = key in self._columns["key"]
            reason = "of several scenarios: use 'SCENARIO/KEY'" if of_several else "not in the summary"
            raise KeyError(f"run {key!r} is {reason}")
        return self.at(row)

    def at(self, row: int) -> Run:
        """Returns the run of a row of the summary."""
        columns = self._columns
        text = set(self._summary.columns) & {"scenario", "key", "outcome", "message", "method", "integrator", "seed"}
        parameters = set(self._summary.parameters)
        metrics = {
            name: float("nan") if values[row] is None else float(values[row])
            for name, values in columns.items()
            if name not in text and name not in parameters
        }
        return Run(
            self._folder,
            scenario=columns["scenario"][row],
            key=columns["key"][row],
            outcome=columns["outcome"][row],
            message=columns["message"][row] or "",
            seed=int(columns["seed"][row]),
            metrics=metrics,
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def __repr__(self) -> str:
        return f"Runs({len(self)} runs)"


def _matches(column: NDArray[Any], value: object) -> NDArray[np.bool_]:
    """Returns which rows of a column of parameters have a value, given as in a scenario."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return np.array([_parsed(cell) == list(value) for cell in column], dtype=bool)
    if isinstance(value, bool):
        # The summary has flags as text.
        value = "true" if value else "false"
    return np.array([cell == value for cell in column], dtype=bool)


def _parsed(cell: object) -> object:
    """Returns a vector that the summary has as text."""
    try:
        return json.loads(cell) if isinstance(cell, str) else cell
    except ValueError:
        return cell


class Results:
    """Results of :func:`stiction.run`, or those of a folder (:func:`stiction.load`).

    A temporary folder exists as long as this object or one of its runs.
    """

    def __init__(self, folder: ResultsFolder, *, complete: bool = True) -> None:
        self._folder = folder
        self._complete = complete
        self._summary = Summary(_native.summary(str(folder.path)))

    @property
    def folder(self) -> Path:
        """Folder of the results."""
        return self._folder.path

    @property
    def summary(self) -> Summary:
        """The table of all runs."""
        return self._summary

    @cached_property
    def runs(self) -> Mapping[str, Run]:
        """The runs by key, in the order of the summary.

        Where two scenarios have a run of the same key, as equal files do, its keys are ``"SCENARIO/KEY"``.
        """
        return self._runs

    @cached_property
    def _runs(self) -> Runs:
        return Runs(self._folder, self._summary)

    def __len__(self) -> int:
        return len(self._summary)

    def __iter__(self) -> Iterator[Run]:
        """Iterates over the runs in the order of the summary."""
        return (self._runs.at(row) for row in range(len(self)))

    def select(self, parameters: Mapping[str, object] | None = None, /, **more: object) -> list[Run]:
        """Returns the runs with these values, in the order of the summary.

        Args:
            parameters: Values of columns of text or swept parameters, such as ``{"contact.method": "exact"}``. Numbers
                must be equal to the last bit; vectors and flags are given as in a scenario.
            **more: The same for names without dots, such as ``scenario="block"``.

        Raises:
            KeyError: The summary has no such column.
        """
        chosen = np.ones(len(self), dtype=bool)
        for name, value in {**(parameters or {}), **more}.items():
            chosen &= _matches(self._summary[name], value)
        return [self._runs.at(int(row)) for row in np.flatnonzero(chosen)]

    def run(self, parameters: Mapping[str, object] | None = None, /, **more: object) -> Run:
        """Returns the only run with these values; arguments as of :meth:`select`.

        Raises:
            KeyError: No run has them, or the summary has no such column.
            ValueError: Several runs have them.
        """
        found = self.select(parameters, **more)
        if len(found) > 1:
            raise ValueError(f"{len(found)} runs match; give more parameters, or use select()")
        if not found:
            raise KeyError(f"no run matches{self._near({**(parameters or {}), **more})}")
        return found[0]

    def _near(self, values: Mapping[str, object]) -> str:
        """Names the values that a column has instead of one that no run has."""
        for name, value in values.items():
            column = self._summary[name]
            if not _matches(column, value).any():
                known = list(dict.fromkeys(cell_text(cell) for cell in column.tolist()))
                more = ", ..." if len(known) > 5 else ""
                return f": {name} is {', '.join(known[:5])}{more}, never {value!r}"
        return ""

    @cached_property
    def outcomes(self) -> dict[str, int]:
        """Number of runs by outcome."""
        return dict(Counter(self._summary["outcome"].tolist()))

    @cached_property
    def failed(self) -> list[Run]:
        """Runs with an expectation that did not hold, or that did not finish unexpectedly."""
        outcomes = self._summary["outcome"]
        rows = np.flatnonzero((outcomes != "passed") & (outcomes != "fallen"))
        return [run for run in (self._runs.at(int(row)) for row in rows) if not run.accepted]

    @property
    def passed(self) -> bool:
        """Whether every run finished and every expectation held.

        After :func:`stiction.run` this includes reference runs and runs that were not started; after
        :func:`stiction.load` it is about the runs of the summary.
        """
        return self._complete and not self.failed

    @property
    def events(self) -> dict[str, list[Event]]:
        """Events of all runs with a log, by the keys of :attr:`runs`. Reads every log.

        Raises:
            LogError: A log cannot be read.
        """
        return {key: run.events for key, run in self.runs.items() if run.log is not None}

    def report(self) -> Path:
        """Returns the path of the report (``report.html``), written from the records if it is missing.

        Raises:
            ResultsError: There are no records, or the report cannot be written.
        """
        path = self.folder / "report.html"
        return path if path.is_file() else Path(_native.report(str(self.folder)))

    def _title(self) -> str:
        outcomes = ", ".join(f"{count} {outcome}" for outcome, count in self.outcomes.items())
        return f"{len(self)} run{'s' if len(self) != 1 else ''}: {outcomes or 'none'}"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._folder, self._complete)

    def __repr__(self) -> str:
        return f"Results({str(self.folder)!r}, {self._title()})"

    def _repr_html_(self) -> str:
        names = self._summary._shown_columns()
        failed = [run.key for run in self.failed]
        order = sorted(range(len(self)), key=lambda row: self._runs._columns["key"][row] not in failed)
        columns = self._runs._columns
        rows = [[cell_text(columns[name][row]) for name in names] for row in order[:_SHOWN_RUNS]]
        more = f"<p>and {len(self) - _SHOWN_RUNS} more</p>" if len(self) > _SHOWN_RUNS else ""
        title = f"<p><b>{html.escape(self._title())}</b></p>"
        return title + html_table(names, rows) + more + f"<p>{html.escape(str(self.folder))}</p>"


def _restored(folder: ResultsFolder, complete: bool) -> Results:
    """Rebuilds pickled results."""
    return Results(folder, complete=complete)


def load(folder: str | os.PathLike[str]) -> Results:
    """Loads the results in a folder, as :func:`stiction.run` and the command ``runner`` write them.

    Raises:
        ResultsError: The folder has no summary, or it cannot be read.
    """
    path = Path(folder)
    if not (path / "summary.parquet").is_file():
        raise ResultsError(f"no results in {path}: it has no summary.parquet; `runner report {path}` writes one")
    return Results(ResultsFolder(path))
