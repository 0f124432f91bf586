"""Progress of a batch: a bar of tqdm, a line of text, or a function of the caller."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Callable, Mapping
from typing import Any, Self, TextIO, TypeAlias

from stiction._errors import ScenarioWarning

Message: TypeAlias = "Mapping[str, Any]"
ProgressLike: TypeAlias = "bool | Callable[[Message], object] | None"


class Counts:
    """Counts the runs of a batch from its messages."""

    def __init__(self) -> None:
        self.total = 0
        self.finished = 0
        self.refused = 0
        self.reference_refused = False

    def __call__(self, message: Message) -> None:
        """Takes a message; warnings about scenarios become Python warnings."""
        event = message["event"]
        if event == "batch-started":
            self.total = message["runs"] + message["references"]
        elif event == "run-finished":
            self.finished += 1
            if not message["accepted"]:
                self.refused += 1
                self.reference_refused |= message["reference"]
        elif event == "diagnostic" and message["severity"] == "warning":
            # Level 1 is this line; the caller of `run` is beyond the native module, whose frames do not count.
            warnings.warn(message["rendered"] or message["message"], ScenarioWarning, stacklevel=4)


class Line:
    """One line of text, rewritten in place."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._width = 0

    def show(self, counts: Counts) -> None:
        """Shows how many runs are done."""
        failed = f", {counts.refused} failed" if counts.refused else ""
        text = f"{counts.finished}/{counts.total} runs{failed}"
        self._stream.write("\r" + text.ljust(self._width))
        self._stream.flush()
        self._width = len(text)

    def close(self) -> None:
        """Ends the line."""
        if self._width:
            self._stream.write("\n")
            self._stream.flush()


class Bar:
    """A bar of tqdm, in the terminal or the notebook."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make
        self._bar: Any = None

    def show(self, counts: Counts) -> None:
        """Shows how many runs are done."""
        if self._bar is None:
            self._bar = self._make(total=counts.total, unit="run")
        if counts.refused:
            self._bar.set_postfix(failed=counts.refused, refresh=False)
        self._bar.update(counts.finished - self._bar.n)

    def close(self) -> None:
        """Leaves the bar as it is."""
        if self._bar is not None:
            self._bar.close()


def _tqdm() -> Callable[..., Any] | None:
    """Returns tqdm for this terminal or notebook; None where it is not installed."""
    try:
        with warnings.catch_warnings():
            # A notebook without widgets gets the bar in text.
            warnings.simplefilter("ignore")
            # By its name, since its types may or may not be installed.
            module = importlib.import_module("tqdm.auto")
    except ImportError:
        return None
    make: Callable[..., Any] = module.tqdm
    return make


def in_notebook() -> bool:
    """Returns whether the code runs in the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")


def _display(progress: bool | None) -> Bar | Line | None:
    if progress is None:
        progress = sys.stderr is not None and (sys.stderr.isatty() or in_notebook())
    if not progress:
        return None
    make = _tqdm()
    return Bar(make) if make is not None else Line(sys.stderr)


class Progress:
    """Receives the messages of a batch, counts them and shows them. A context manager: its end ends the display.

    Args:
        progress: True: shown; None: shown on a terminal or in a notebook; False: not shown; a function receives each
            message instead.
    """

    def __init__(self, progress: ProgressLike) -> None:
        self.counts = Counts()
        self._callback = progress if callable(progress) else None
        self._display = None if callable(progress) else _display(progress)

    def __call__(self, message: Message) -> None:
        self.counts(message)
        if self._callback is not None:
            self._callback(message)
        elif self._display is not None and message["event"] in ("batch-started", "run-finished"):
            self._display.show(self.counts)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._display is not None:
            self._display.close()
