"""Starts worker processes, sends them requests, and ends those that crash or take too long."""

import contextlib
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

#: Time in which an engine must load, s. Some compile kernels at their first import.
LOAD_LIMIT = 300.0
#: One thread for each library of linear algebra.
THREADS = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"]


class TimedOut(Exception):
    """No answer within the limit; the worker was killed."""


class Crashed(Exception):
    """The worker ended without an answer; the text says how."""


class WorkerProcess:
    """A worker process, in a group of its own and a working directory of its own."""

    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="stiction-engines-")
        self.output = Path(self.folder) / "output"
        package = str(Path(__file__).resolve().parents[1])
        paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = (
            os.environ
            | {name: "1" for name in THREADS}
            | {
                "PYTHONPATH": os.pathsep.join(paths),
                "STICTION_ENGINE_OUTPUT": str(self.output),
                "TMPDIR": self.folder,
            }
        )
        runner = os.environ.get("STICTION_RUNNER")
        if runner and os.path.exists(runner):
            environment["STICTION_RUNNER"] = os.path.abspath(runner)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "stiction_engines.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=self.folder,
            env=environment,
            start_new_session=True,
        )
        self.received = b""

    def ask(self, request, limit):
        """The answer to a request. Raises `TimedOut` or `Crashed`; the worker has ended then."""
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            self.process.stdin.flush()
            line = self._line(time.monotonic() + limit)
        except BrokenPipeError:
            line = b""
        except TimedOut:
            self.close()
            raise
        if line:
            return json.loads(line)
        # The pipe of answers closes a moment before the process has ended.
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(5)
        how = self._ended()
        self.close()
        raise Crashed(how)

    def _line(self, deadline):
        """The next line of answers; empty if the worker has closed its end."""
        descriptor = self.process.stdout.fileno()
        while b"\n" not in self.received:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([descriptor], [], [], left)[0]:
                raise TimedOut
            part = os.read(descriptor, 65536)
            if not part:
                return b""
            self.received += part
        line, self.received = self.received.split(b"\n", 1)
        return line

    def _ended(self):
        """How the process ended, and the last line that it printed."""
        code = self.process.returncode
        if code is None:
            how = "the engine's process closed its pipe"
        elif code < 0:
            how = f"the engine's process ended by {signal.Signals(-code).name}"
        else:
            how = f"the engine's process exited with code {code}"
        printed = self.output.read_text(errors="replace") if self.output.exists() else ""
        if not printed and select.select([self.process.stderr], [], [], 0)[0]:
            printed = os.read(self.process.stderr.fileno(), 65536).decode(errors="replace")
        lines = [line.strip() for line in printed.splitlines() if line.strip()]
        return f"{how}: {lines[-1][:200]}" if lines else how

    def close(self):
        """Ends the process and what it started, and removes its folder."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            with contextlib.suppress(OSError):
                pipe.close()
        shutil.rmtree(self.folder, ignore_errors=True)


def _described(name):
    worker = WorkerProcess()
    try:
        answer = worker.ask({"do": "describe", "engine": name}, LOAD_LIMIT)
    except Crashed as error:
        return {"missing": f"cannot be loaded ({error})"}
    except TimedOut:
        return {"missing": f"cannot be loaded (not within {LOAD_LIMIT:g} s)"}
    finally:
        worker.close()
    if answer["outcome"] != "passed":
        return {"missing": f"cannot be loaded ({answer['message']})"}
    return answer


def described(names, jobs=2):
    """Answers to `describe` by adapter: `name`, `version` and `settings`, or `missing` with the reason."""
    with ThreadPoolExecutor(jobs) as pool:
        return dict(zip(names, pool.map(_described, names)))
