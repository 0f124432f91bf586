"""Runs cells, that is case x engine x settings x step, in worker processes and collects their errors.

Each worker keeps one engine loaded and runs one cell after the other. A cell that exceeds the time limit is
`timed-out`, one whose engine crashes is an `error`; in both cases a new worker continues with the next cell.
"""

import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from .worker_process import LOAD_LIMIT, Crashed, TimedOut, WorkerProcess


@dataclass(frozen=True)
class Cell:
    """A case with an engine, its settings, and a fixed step or a relative tolerance."""

    case: str
    file: Path
    adapter: str
    engine: str
    version: str
    settings: str
    step: float
    adaptive: bool

    def request(self, do):
        """A request for a worker."""
        return {
            "do": do,
            "engine": self.adapter,
            "case": str(self.file),
            "settings": self.settings,
            "step": self.step,
        }


@dataclass
class Result:
    """Outcome and figures of a cell. `cpu` and `noise` come from `cost`, None without it.

    `wall`: wall-clock time with set-up and record, s. `noise`: median and greatest of the probes over the
    least, each minus 1. `cost_message`: why there is no cost.
    """

    outcome: str = "cancelled"
    message: str = "interrupted"
    wall: float | None = None
    duration: float | None = None
    steps: int | None = None
    values: dict[str, float] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    cpu: float | None = None
    noise: tuple[float, float] | None = None
    cost_message: str = ""


def cells(cases, engines, settings=(), steps=(), tolerances=()):
    """Cells of cases and engines, by engine, so that workers load few of them.

    `engines` are answers to `describe` by adapter. `settings` selects by name, `steps` and `tolerances`
    replace those of the settings.
    """
    found = []
    for adapter, engine in engines.items():
        for known in cases:
            for choice in engine["settings"]:
                if settings and choice["name"] not in settings:
                    continue
                replaced = tolerances if choice["adaptive"] else steps
                for step in replaced or choice["steps"]:
                    found.append(
                        Cell(
                            known.name,
                            known.file,
                            adapter,
                            engine["name"],
                            engine["version"],
                            choice["name"],
                            float(step),
                            choice["adaptive"],
                        )
                    )
    return found


def result_of(answer):
    """The result in an answer of a worker."""
    numbers = lambda key: {name: float(value) for name, value in answer.get(key, {}).items()}
    return Result(
        answer["outcome"],
        answer["message"],
        answer["wall"],
        answer.get("duration"),
        answer.get("steps"),
        numbers("values"),
        numbers("errors"),
    )


class _Thread:
    """Runs cells in a worker of its own, which it restarts for another engine."""

    def __init__(self, limit):
        self.limit = limit
        self.adapter, self.worker = None, None

    def run(self, cell):
        """The result of a cell."""
        begin = time.monotonic()
        try:
            if self.adapter != cell.adapter or self.worker is None:
                self.close()
                self.adapter, self.worker = cell.adapter, WorkerProcess()
                self.worker.ask({"do": "describe", "engine": cell.adapter}, LOAD_LIMIT)
                begin = time.monotonic()
            return result_of(self.worker.ask(cell.request("accuracy"), self.limit))
        except TimedOut:
            self.worker = None
            return Result("timed-out", f"more than {self.limit:g} s", time.monotonic() - begin)
        except Crashed as error:
            self.worker = None
            return Result("error", str(error), time.monotonic() - begin)

    def close(self):
        """Ends the worker."""
        worker, self.worker = self.worker, None
        if worker:
            worker.close()


def run(cells, jobs, limit, report=lambda case, engine, results: None):
    """Results of cells, in their order. Cells that an interruption leaves are `cancelled`.

    `jobs` workers run in parallel, each cell at most `limit` seconds. `report` gets the results of each case
    and engine when they are complete. The second value is False after an interruption.
    """
    results = [Result() for _ in cells]
    waiting = iter(range(len(cells)))
    left = Counter((cell.case, cell.engine) for cell in cells)
    lock, stop, faults = threading.Lock(), threading.Event(), []

    def work():
        thread = _Thread(limit)
        threads.append(thread)
        try:
            while not stop.is_set():
                with lock:
                    k = next(waiting, None)
                if k is None:
                    return
                result = thread.run(cells[k])
                group = cells[k].case, cells[k].engine
                with lock:
                    if stop.is_set():
                        return
                    results[k] = result
                    left[group] -= 1
                    if not left[group]:
                        report(*group, [r for c, r in zip(cells, results) if (c.case, c.engine) == group])
        except Exception as error:  # A fault of this module: it ends the sweep.
            faults.append(error)
            stop.set()
        finally:
            thread.close()

    threads = []
    workers = [threading.Thread(target=work, daemon=True) for _ in range(max(1, min(jobs, len(cells))))]
    for worker in workers:
        worker.start()
    try:
        for worker in workers:
            worker.join()
    except KeyboardInterrupt:
        stop.set()
        for thread in threads:
            thread.close()
        for worker in workers:
            worker.join(5)
        return results, False
    if faults:
        raise faults[0]
    return results, True
