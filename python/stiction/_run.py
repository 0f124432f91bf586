"""One run of a batch."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction._errors import LogError, ResultsError
from stiction._log import Event, Log
from stiction._table import Series

if TYPE_CHECKING:
    from stiction._results import ResultsFolder


def _number(value: float | str | None) -> float | None:
    """Returns a number of a record, which has ``"inf"``, ``"-inf"`` and ``"NaN"`` as text."""
    return None if value is None else float(value)


@dataclass(frozen=True)
class Expectation:
    """The result of one expectation in a run. Numbers are in the metric's unit.

    Attributes:
        metric: A numeric column of the summary, or ``"outcome"``.
        held: Whether it held.
        measured: Measured value; None for an outcome, and for an event that did not occur.
        value: Expected value; None where there are only limits.
        allowed: Largest allowed distance from ``value``.
        min: Smallest allowed value.
        max: Largest allowed value.
        error: Measured minus expected value; with limits, the distance beyond them, 0 between them.
        message: Reason of a failure; may be empty.
    """

    metric: str
    held: bool
    measured: float | None
    value: float | None
    allowed: float | None
    min: float | None
    max: float | None
    error: float | None
    message: str

    @classmethod
    def _of(cls, verdict: Mapping[str, Any]) -> Expectation:
        numbers = {name: _number(verdict[name]) for name in ("measured", "allowed", "min", "max", "error")}
        return cls(
            metric=verdict["metric"],
            held=verdict["held"],
            value=_number(verdict["truth"]),
            message=verdict["message"],
            **numbers,
        )


class Run:
    """One run of :class:`stiction.Results`: its outcome, metrics, record and log.

    Attributes:
        scenario: Name of the scenario.
        key: Hash of everything that determines the result.
        outcome: ``"passed"``, ``"failed"``, ``"fallen"``, ``"diverged"``, ``"stalled"``, ``"timed-out"``, ``"error"``
            or ``"cancelled"``.
        message: Reason of the outcome; may be empty.
        seed: Seed.
        metrics: The numeric columns of the summary by name; NaN where nothing was measured.
    """

    def __init__(
        self,
        results: ResultsFolder,
        *,
        scenario: str,
        key: str,
        outcome: str,
        message: str,
        seed: int,
        metrics: Mapping[str, float],
    ) -> None:
        # Keeps a temporary folder as long as the run.
        self._results = results
        self.scenario = scenario
        self.key = key
        self.outcome = outcome
        self.message = message
        self.seed = seed
        self.metrics = metrics

    @cached_property
    def folder(self) -> Path:
        """Folder of the run's record and log.

        Raises:
            ResultsError: There is none.
        """
        scenario = self._results.path / self.scenario
        # Large sweeps divide their folders by the first digits of the key.
        parts = ("", self.key[:2], f"{self.key[:2]}/{self.key[2:4]}")
        candidates = [scenario / part / self.key for part in parts]
        for folder in candidates:
            if (folder / "run.json").is_file():
                return folder
        raise ResultsError(f"run {self.key} has no record: {candidates[0] / 'run.json'}")

    @cached_property
    def record(self) -> Mapping[str, Any]:
        """The record (``run.json``), read when first used. Its numbers may be the texts inf, -inf and NaN.

        Raises:
            ResultsError: It is missing or cannot be read.
        """
        path = self.folder / "run.json"
        try:
            record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ResultsError(f"cannot read {path}: {error}") from error
        return record

    @cached_property
    def parameters(self) -> Mapping[str, object]:
        """Swept parameters under their dotted names, in file order. Vectors and tables are text."""
        return dict(self.record["parameters"])

    @cached_property
    def expectations(self) -> list[Expectation]:
        """Expectations in file order; none if the run ended before they were evaluated."""
        return [Expectation._of(verdict) for verdict in self.record["verdicts"]]

    @property
    def notes(self) -> list[str]:
        """Further notes, such as that the run is implausible."""
        return list(self.record.get("notes", []))

    @property
    def accepted(self) -> bool:
        """Whether the run ended as expected and every expectation held."""
        if self.outcome in ("passed", "fallen"):
            return True
        if self.outcome == "failed":
            return False
        # Another outcome is accepted where an expectation names it.
        return bool(self.expectations) and all(expectation.held for expectation in self.expectations)

    @property
    def log(self) -> Path | None:
        """Path of the log; None without one."""
        path = self.folder / "log.mcap"
        return path if path.is_file() else None

    def _opened(self) -> Log:
        path = self.log
        if path is None:
            raise LogError(f"run {self.key} has no log: it ran with log=False or log.rate = 0")
        return Log(path)

    def columns(self) -> list[str]:
        """Returns the names of all columns of :meth:`series`.

        Raises:
            LogError: There is no log, or it cannot be read.
        """
        return self._opened().columns()

    def series(
        self,
        columns: str | Iterable[str] | None = None,
        *,
        rate: float | None = None,
        start: float | None = None,
        end: float | None = None,
    ) -> Series:
        """Reads time series of the log, with the columns and values of ``runner export``.

        Args:
            columns: Names, with the wildcards ``*`` and ``?``; None: all. ``time_s`` is always the first column.
            rate: Rows at ``start + k / rate`` (Hz), linearly interpolated; None: the instants of the log.
            start: First time, s; None: the start of the log.
            end: Last time, s, included; None: the end of the log.

        Raises:
            LogError: There is no log, it cannot be read, or a name matches no column.
        """
        return self._opened().series(columns, rate=rate, start=start, end=end)

    @property
    def events(self) -> list[Event]:
        """Events in order of time, read from the log.

        Raises:
            LogError: There is no log, or it cannot be read.
        """
        return self._opened().events

    @property
    def resolved(self) -> str:
        """The scenario of the run as TOML, with all defaults, in SI units and radians."""
        text: str = self.record["resolved"]
        return text

    def __reduce__(self) -> tuple[Any, ...]:
        values = {name: getattr(self, name) for name in ("scenario", "key", "outcome", "message", "seed", "metrics")}
        return _restored, (self._results, values)

    def __repr__(self) -> str:
        return f"Run({self.scenario!r}, key={self.key!r}, outcome={self.outcome!r})"

    def _repr_html_(self) -> str:
        from stiction._table import cell_text, html_table

        rows = [["outcome", self.outcome], ["message", self.message], ["key", self.key]]
        rows += [[name, cell_text(value)] for name, value in self.parameters.items()]
        rows += [[name, cell_text(value)] for name, value in self.metrics.items() if not math.isnan(value)][:20]
        return html_table([self.scenario, ""], [row for row in rows if row[1]])


def _restored(results: ResultsFolder, values: dict[str, Any]) -> Run:
    """Rebuilds a pickled run."""
    return Run(results, **values)
