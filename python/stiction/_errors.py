"""Errors of the package. The native module raises these classes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Diagnostic:
    """An error, warning or note about a scenario or a robot.

    Attributes:
        severity: ``"error"``, ``"warning"`` or ``"note"``.
        message: What is wrong, in one line.
        file: The file; ``--set`` or ``--filter`` for values of ``set`` and ``filter``; None without one.
        line: Line, from 1; None without one.
        column: Column in characters, from 1; None without one.
        key: Dotted path of the key, or the element of a robot file; None without one.
        help: How to fix it; None without advice.
        rendered: The complete text with the excerpt of the file, in several lines.
    """

    severity: str
    message: str
    file: str | None = None
    line: int | None = None
    column: int | None = None
    key: str | None = None
    help: str | None = None
    rendered: str = ""

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Diagnostic:
        """Reads a diagnostic of the native module; other keys are ignored."""
        return cls(**{name: values[name] for name in cls.__dataclass_fields__ if name in values})

    def __str__(self) -> str:
        return self.rendered or f"{self.severity}: {self.message}"


class Error(Exception):
    """Base class of the errors of this package."""


class ScenarioError(Error, ValueError):
    """A scenario, a value of ``set`` or a filter is invalid.

    ``str()`` is the text with the excerpt of the file. ``file``, ``line``, ``column``, ``key`` and ``help`` are
    those of the first error.

    Attributes:
        diagnostics: All errors.
    """

    diagnostics: tuple[Diagnostic, ...]

    def __init__(self, message: str, diagnostics: Iterable[Diagnostic | Mapping[str, Any]] = ()) -> None:
        super().__init__(message)
        self.diagnostics = tuple(
            entry if isinstance(entry, Diagnostic) else Diagnostic.from_dict(entry) for entry in diagnostics
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.diagnostics)

    @property
    def _first(self) -> Diagnostic:
        errors = [entry for entry in self.diagnostics if entry.severity == "error"]
        return errors[0] if errors else Diagnostic("error", str(self))

    @property
    def file(self) -> str | None:
        """File of the first error; ``--set`` or ``--filter`` for values of ``set`` and ``filter``."""
        return self._first.file

    @property
    def line(self) -> int | None:
        """Line of the first error, from 1."""
        return self._first.line

    @property
    def column(self) -> int | None:
        """Column of the first error in characters, from 1."""
        return self._first.column

    @property
    def key(self) -> str | None:
        """Dotted path of the key of the first error."""
        return self._first.key

    @property
    def help(self) -> str | None:
        """How to fix the first error."""
        return self._first.help


class RobotError(ScenarioError):
    """A robot file or URDF is invalid or cannot be read."""


class RunError(Error, RuntimeError):
    """A simulation cannot start or continue.

    Attributes:
        outcome: The outcome of the run, such as ``"diverged"``.
        time: Simulated time at which it ended, s; None before the start.
    """

    outcome: str
    time: float | None

    def __init__(self, message: str, outcome: str = "error", time: float | None = None) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.time = time

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.outcome, self.time)


class LogError(Error, ValueError):
    """A log or table cannot be read, or has no such column."""


class ResultsError(Error):
    """Results cannot be written or read."""


class ScenarioWarning(UserWarning):
    """A warning about a scenario or a robot."""
