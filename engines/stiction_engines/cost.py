"""Measures processor time of cells in one process on one processor, all cells of a case interleaved.

The least of several rounds counts. The probe, a fixed piece of work, is timed between cells: the spread of
its times is the machine's noise while a case was measured.
"""

import statistics
import time

from .worker_process import LOAD_LIMIT, Crashed, TimedOut, WorkerProcess

#: A cell that takes longer than this in its first round is not repeated, s.
NOT_REPEATED = 5.0
#: The first run of an engine in a case is a warm-up if it is shorter than this, s.
WARM_UP = 0.3
#: Limit of a run: this many times the wall-clock time of its accuracy, and some seconds.
LIMIT_FACTOR, LIMIT_EXTRA = 3.0, 30.0


class _Process:
    """The process that measures; a new one after each crash."""

    def __init__(self):
        self.worker, self.loaded = None, set()

    def ask(self, request, limit):
        """The answer to a request. Raises `TimedOut` or `Crashed`."""
        if self.worker is None:
            self.worker = WorkerProcess()
            self.loaded.clear()
            self._ask({"do": "pin"}, LOAD_LIMIT)
            # The first probe of a process is slower than others.
            self._ask({"do": "probe"}, LOAD_LIMIT)
        engine = request.get("engine")
        if engine is not None and engine not in self.loaded:
            self._ask({"do": "describe", "engine": engine}, LOAD_LIMIT)
            self.loaded.add(engine)
        return self._ask(request, limit)

    def _ask(self, request, limit):
        try:
            return self.worker.ask(request, limit)
        except (TimedOut, Crashed):
            self.worker = None
            raise

    def close(self):
        """Ends the process."""
        if self.worker:
            self.worker.close()


class _CaseCost:
    """Measures the cells of a case: pairs of cell and result, all of them `passed`."""

    def __init__(self, process, pairs, rounds):
        self.process, self.pairs, self.rounds = process, pairs, rounds
        self.probes, self.lost, self.first = [], {}, {}
        self.warm = set()
        self.deadline = time.monotonic() + (rounds + 1) * sum(self.limit(result) for _, result in pairs)

    @staticmethod
    def limit(result):
        """Limit of a run, s."""
        return LIMIT_FACTOR * result.wall + LIMIT_EXTRA

    def measure(self):
        """Fills in `cpu`, `steps` and `noise` of the results."""
        for turn in range(self.rounds):
            for cell, result in self.pairs:
                if time.monotonic() > self.deadline:
                    result.cost_message = result.cost_message or "the case took too long"
                elif cell.adapter not in self.lost and self.first.get(cell, 0.0) <= NOT_REPEATED:
                    self.once(cell, result, turn)
        for cell, result in self.pairs:
            if cell.adapter in self.lost:
                result.cpu, result.cost_message = None, self.lost[cell.adapter]
            elif result.cpu is not None:
                least = min(self.probes)
                result.noise = statistics.median(self.probes) / least - 1, max(self.probes) / least - 1

    def once(self, cell, result, turn):
        """Measures a cell once."""
        try:
            self.probes.append(self.process.ask({"do": "probe"}, LOAD_LIMIT)["cpu"])
            answer = self.process.ask(cell.request("cost"), self.limit(result))
            if answer["outcome"] == "passed" and cell.adapter not in self.warm:
                self.warm.add(cell.adapter)
                if answer["cpu"] < WARM_UP:
                    answer = self.process.ask(cell.request("cost"), self.limit(result))
        except TimedOut:
            self.lost[cell.adapter] = f"{cell.settings} at {cell.step:g}: more than {self.limit(result):g} s"
            return
        except Crashed as error:
            self.lost[cell.adapter] = f"{cell.settings} at {cell.step:g}: {error}"
            return
        if answer["outcome"] != "passed":
            result.cost_message = f"{answer['outcome']}: {answer['message']}"
            self.first[cell] = float("inf")
            return
        if turn == 0:
            self.first[cell] = answer["cpu"]
        if result.cpu is None or answer["cpu"] < result.cpu:
            result.cpu, result.steps = answer["cpu"], answer["steps"]


def run(cells, results, rounds, report=lambda case, pairs: None):
    """Measures the costs of cells that passed, and fills them in. Returns False after an interruption.

    An engine that crashes or exceeds its limit loses its costs of that case. `report` gets the pairs of cell
    and result of each case when it is complete.
    """
    cases = {}
    for cell, result in zip(cells, results):
        if result.outcome == "passed":
            cases.setdefault(cell.case, []).append((cell, result))
    process = _Process()
    try:
        for name in sorted(cases):
            _CaseCost(process, cases[name], rounds).measure()
            report(name, cases[name])
    except KeyboardInterrupt:
        return False
    finally:
        process.close()
    return True
