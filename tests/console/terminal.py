"""Drives the console of the program in a pseudo-terminal and waits for its output.

The arguments are the command.
"""

import os
import pty
import re
import select
import sys

child, terminal = pty.fork()
if child == 0:
    os.environ["TERM"] = "xterm"
    os.execv(sys.argv[1], sys.argv[1:])

seen = b""


def wait(pattern):
    """Reads until the pattern appears, at most a minute, and discards the text up to its end."""
    global seen
    while True:
        found = re.search(pattern, seen)
        if found:
            seen = seen[found.end() :]
            return found
        if not select.select([terminal], [], [], 60)[0]:
            sys.exit(f"no {pattern!r} in {seen!r}")
        try:
            more = os.read(terminal, 65536)
        except OSError:
            more = b""
        if not more:
            sys.exit(f"ended without {pattern!r}: {seen!r}")
        seen += more


def write(text):
    os.write(terminal, text)


def prompt():
    """Waits until the program reads a line.

    Before that, the terminal would turn Ctrl-C into a signal. The prompt text alone does not
    suffice, because it is redrawn with each letter.
    """
    wait(rb"\x1b\[\?2004h")
    wait(rb"s> ")


def enter(text):
    """Types a line and waits until the program accepts it."""
    write(text + b"\r")
    wait(rb"\x1b\[\?2004l")


def tick(beyond):
    """Polls `status` until the run is beyond a tick, and returns the present tick.

    A change before the first tick is no event, and an event appears only after a further tick.
    """
    while True:
        prompt()
        enter(b"status")
        number = int(wait(rb"tick (\d+), running until 600 s").group(1))
        if number > beyond:
            return number


prompt()
write(b"hel\t")
wait(rb"help")
enter(b" ra\t")
wait(rb"rate FACTOR\|realtime\|free")
prompt()
enter(b"nonsense")
wait(rb"there is no command `nonsense`")
prompt()
# Without a time, the run continues until it is paused.
enter(b"run")
now = tick(0)
prompt()
enter(b"floor 0.3 0.2")
tick(tick(now))
prompt()
write(b"\x03")
wait(rb"event floor\.friction")
prompt()
enter(b"rate free")
prompt()
enter(b"run 0.5")
wait(rb"\d s\r?\n")
# A change that makes the run diverge is undone.
enter(b"start sine joints.x.amplitude=1")
wait(rb"has no joint `x`")
prompt()
enter(b"set gravity=[0,0,1e200]")
prompt()
enter(b"run 1")
wait(rb"the run has ended at")
enter(b"undo")
wait(rb"\d s\r?\n")
enter(b"run 0.1")
wait(rb"\d s\r?\n")
enter(b"floor")
wait(rb"static 0\.3, kinetic 0\.2")
prompt()
write(b"\x04")
wait(rb"s\.toml: ")
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status))
