"""Types at the program's console in a terminal and waits for what is to be seen. The program is in the arguments."""

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
    """Reads until the pattern is there, at most a minute; what was read up to its end is done with."""
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
    """Waits until a line is read. Before that the terminal would make a signal of Ctrl-C; the prompt's text alone is drawn again with each letter."""
    wait(rb"\x1b\[\?2004h")
    wait(rb"s> ")


def enter(text):
    """Types a line and waits until it is taken."""
    write(text + b"\r")
    wait(rb"\x1b\[\?2004l")


def tick(beyond):
    """Asks until a run has gone beyond a tick, and tells where it is. What is changed before its first tick is no event, and an event is told once it has gone on."""
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
# Without a time it goes on until it is held.
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
# A change that breaks the run is taken back.
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
