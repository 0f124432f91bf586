"""Worker process: loads engines and runs cells of them on request.

    python -m stiction_engines.worker

A request is one line of JSON on standard input, its answer one line of JSON on standard output. The output
of engines goes to the file that STICTION_ENGINE_OUTPUT names. Requests:

    {"do": "describe", "engine": NAME}                               version and settings
    {"do": "accuracy", "engine", "case": FILE, "settings", "step"}   values and errors of all measures
    {"do": "cost", "engine", "case", "settings", "step"}             processor time and number of steps
    {"do": "pin"}                                                    keeps the process on one processor
    {"do": "probe"}                                                  processor time of fixed work

Numbers that are not finite are the strings `inf`, `-inf`, `nan`.
"""

import gc
import json
import math
import os
import sys
import time

import numpy

from . import adapters, case, measure
from .engine import Failed, Unsupported

#: Passes of the loop of the probe, which take about 2 ms.
PROBE = 8000


def finite_or_text(number):
    """A number for JSON."""
    return number if number is None or math.isfinite(number) else repr(float(number))


def text(error):
    """The text of an exception in one line of at most 300 characters."""
    return " ".join(str(error).split())[:300]


def probe():
    """Processor time of fixed work, s."""
    values = numpy.linspace(0.0, 1.0, 2000)
    begin = time.process_time()
    total = 0
    for k in range(PROBE):
        total += k * k
        if k % 100 == 0:
            values = numpy.sqrt(values * values + 1e-3)
    return time.process_time() - begin


class Worker:
    """Engines and cases that this process has loaded."""

    def __init__(self):
        self.engines, self.cases = {}, {}

    def engine(self, name):
        """The engine of this name."""
        if name not in self.engines:
            self.engines[name] = adapters.load(name)
        return self.engines[name]

    def cell(self, request):
        """Engine, case, settings and step of a request."""
        engine, file = self.engine(request["engine"]), request["case"]
        if file not in self.cases:
            self.cases[file] = case.read(file)
        settings = next(s for s in engine.settings() if s.name == request["settings"])
        return engine, (self.cases[file], settings, request["step"])

    def describe(self, request):
        """Version and settings of an engine, or why there is none."""
        try:
            engine = self.engine(request["engine"])
        except adapters.NotInstalled as error:
            return {"missing": str(error)}
        settings = [
            {"name": s.name, "description": s.description, "steps": s.steps, "adaptive": s.adaptive}
            for s in engine.settings()
        ]
        return {"name": engine.name, "version": engine.version(), "settings": settings}

    def accuracy(self, request):
        """Values and errors of all measures of a run."""
        engine, (known, settings, step) = self.cell(request)
        series = engine.record(known, settings, step)
        found = measure.errors(known, series)
        return {
            "values": {name: finite_or_text(value) for name, (value, _) in found.items()},
            "errors": {name: finite_or_text(error) for name, (_, error) in found.items()},
            "duration": float(series.time[-1] - series.time[0]),
            # Rows of an adaptive run are reports, not steps.
            "steps": None if settings.adaptive else len(series.time) - 1,
        }

    def cost(self, request):
        """Processor time and number of steps of a run."""
        engine, cell = self.cell(request)
        gc.collect()
        seconds, steps = engine.cost(*cell)
        return {"cpu": float(seconds), "steps": int(steps)}

    def pin(self, _):
        """Keeps the process, and programs that it starts, on one of its processors."""
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
        return {}

    def probe(self, _):
        """Processor time of the probe."""
        return {"cpu": probe()}

    def answer(self, request):
        """The answer to a request: the outcome, a message, and more where the outcome is `passed`."""
        begin, outcome, message, more = time.perf_counter(), "passed", "", {}
        try:
            more = getattr(self, request["do"])(request)
        except Unsupported as error:
            outcome, message = "unsupported", text(error)
        except Failed as error:
            outcome, message = "diverged", text(error)
        except (Exception, SystemExit) as error:
            outcome, message = "error", f"{type(error).__name__}: {text(error)}"
        return {"outcome": outcome, "message": message, "wall": time.perf_counter() - begin} | more


def main():
    requests, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    output = os.environ.get("STICTION_ENGINE_OUTPUT", os.devnull)
    shown = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    nothing = os.open(os.devnull, os.O_RDONLY)
    for target, source in ((0, nothing), (1, shown), (2, shown)):
        os.dup2(source, target)
    worker = Worker()
    for line in requests:
        if output != os.devnull:
            os.ftruncate(shown, 0)
        print(json.dumps(worker.answer(json.loads(line)), allow_nan=False), file=answers, flush=True)
        sys.stdout.flush()


if __name__ == "__main__":
    main()
