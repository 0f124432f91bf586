"""Reading of logs: time series and events."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from stiction import _native
from stiction._table import Series, Table


@dataclass(frozen=True)
class Event:
    """An event of a run.

    Attributes:
        time: Simulated time, s.
        kind: Such as ``"touchdown"``, ``"liftoff"``, ``"slip"``, ``"stick"`` or ``"impact"``.
        subject: The sole, link, body or task; may be empty.
        message: Text; may be empty.
    """

    time: float
    kind: str
    subject: str
    message: str


class Log:
    """A log (``log.mcap``) on disk. Each call reads the file.

    Args:
        path: The file.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def columns(self) -> list[str]:
        """Returns the names of all columns of :meth:`series`.

        Raises:
            LogError: The log cannot be read.
        """
        return _native.columns(str(self.path))

    def series(
        self,
        columns: str | Iterable[str] | None = None,
        *,
        rate: float | None = None,
        start: float | None = None,
        end: float | None = None,
    ) -> Series:
        """Reads time series, with the columns and values of ``runner export``.

        Args:
            columns: Names, with the wildcards ``*`` and ``?``; None: all. ``time_s`` is always the first column.
            rate: Rows at ``start + k / rate`` (Hz), linearly interpolated; None: the instants of the log.
            start: First time, s; None: the start of the log.
            end: Last time, s, included; None: the end of the log.

        Raises:
            LogError: The log cannot be read, or a name matches no column.
        """
        if columns is None:
            names = ["*"]
        else:
            names = [columns] if isinstance(columns, str) else list(columns)
        return Series(_native.series(str(self.path), names, rate, start, end))

    @property
    def events(self) -> list[Event]:
        """All events, in order of time.

        Raises:
            LogError: The log cannot be read.
        """
        table = Table(_native.events(str(self.path)))
        times = table["time_s"].tolist()
        kinds, subjects, messages = ([text or "" for text in table[name]] for name in ("kind", "subject", "message"))
        return [Event(*values) for values in zip(times, kinds, subjects, messages, strict=True)]

    def __repr__(self) -> str:
        return f"Log({str(self.path)!r})"
