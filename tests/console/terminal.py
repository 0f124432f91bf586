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


wait(rb"0 s> ")
write(b"hel\t")
wait(rb"help")
write(b" ra\t\r")
wait(rb"rate FACTOR\|realtime\|free")
wait(rb"s> ")
write(b"nonsense\r")
wait(rb"there is no command `nonsense`")
wait(rb"s> ")
# Without a time it goes on until it is held.
write(b"run\r")
wait(rb"s> ")
write(b"status\r")
wait(rb"running until 600 s")
wait(rb"s> ")
write(b"floor 0.3 0.2\r")
wait(rb"s> ")
write(b"\x03")
wait(rb"event floor\.friction")
wait(rb"s> ")
write(b"rate free\r")
wait(rb"s> ")
write(b"run 0.5\r")
wait(rb"\d s\r?\n")
# A change that breaks the run is taken back.
write(b"start sine joints.x.amplitude=1\r")
wait(rb"has no joint `x`")
wait(rb"s> ")
write(b"set gravity=[0,0,1e200]\r")
wait(rb"s> ")
write(b"run 1\r")
wait(rb"the run has ended at")
write(b"undo\r")
wait(rb"\d s\r?\n")
write(b"run 0.1\r")
wait(rb"\d s\r?\n")
write(b"floor\r")
wait(rb"static 0\.3, kinetic 0\.2")
wait(rb"s> ")
write(b"\x04")
wait(rb"s\.toml: ")
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status))
