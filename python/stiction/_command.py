"""The command ``runner`` of the package."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

from stiction import _native


def _launcher() -> str:
    """Returns the path of a program that starts the command again, as jobs of ``runner submit`` do."""
    called = os.path.abspath(sys.argv[0])
    if os.path.basename(called) != "__main__.py":
        return called
    # `python -m stiction`: the console script that was installed next to this interpreter, if any.
    folder = os.path.dirname(os.path.abspath(sys.executable))
    scripts = (os.path.join(folder, name) for name in ("runner", "runner.exe"))
    return next((script for script in scripts if os.path.isfile(script)), called)


def main() -> NoReturn:
    """Runs the command with the arguments of the process and exits with its code."""
    # The native module handles Ctrl-C itself; Python's handler would only set a flag meanwhile.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    raise SystemExit(_native.main(_launcher(), sys.argv[1:]))
