"""Running of scenarios."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

from stiction import _native
from stiction._progress import Progress, ProgressLike
from stiction._results import Results, ResultsFolder
from stiction._scenario import Scenario, ScenarioLike, collect

Override = tuple[str, object]


def native_inputs(
    scenarios: list[Scenario], values: Mapping[str, object] | None
) -> tuple[list[_native.ScenarioFile], list[Override]]:
    """Returns the files and the overrides of a batch. Values of a scenario precede those of the batch."""
    files = [scenario._file for scenario in scenarios]
    common = scenarios[0]._set
    # Values are not compared: equality of arrays is one of their entries, and 1 equals True.
    if all(scenario._set is common or not (scenario._set or common) for scenario in scenarios):
        return files, list({**common, **(values or {})}.items())
    own = [file.with_overrides(list(scenario._set.items())) for file, scenario in zip(files, scenarios, strict=True)]
    return own, list((values or {}).items())


def run(
    scenarios: ScenarioLike | Iterable[ScenarioLike],
    *,
    set: Mapping[str, object] | None = None,
    jobs: int | None = None,
    output: str | os.PathLike[str] | None = None,
    filter: str | None = None,
    log: bool = True,
    timeout: float | None = None,
    max_fail: int | None = None,
    slow: float | None = None,
    timing: bool = True,
    resume: bool = False,
    max_runs: int | None = None,
    progress: ProgressLike = None,
    folder: str | os.PathLike[str] | None = None,
) -> Results:
    """Runs scenarios in parallel, as the command ``runner`` does, with the same bits.

    Runs that fail raise nothing: see :attr:`Results.passed <stiction.Results.passed>`. Ctrl-C lets no more runs start
    and cancels the active ones; results of finished runs stay in ``output``.

    Args:
        scenarios: A path of a file or of a folder of ``.toml`` files, a dictionary with the keys of a scenario file, a
            :class:`stiction.Scenario`, or an iterable of these. Several dictionaries are named ``scenario-1``,
            ``scenario-2``, ...
        set: Values by dotted key for all scenarios, as of ``--set``.
        jobs: Parallel runs; None: one per processor.
        output: Folder of the results; None: a temporary folder, removed with the returned object and its runs.
        filter: Condition that selects runs, such as ``'name ~ "push*" and floor.friction.static < 0.5'``.
        log: Whether runs write logs; without, there are no time series and no events.
        timeout: Wall-clock limit of each run, s, which then is ``timed-out``.
        max_fail: Start no more runs after so many failed or did not finish.
        slow: Report runs that take longer, wall-clock s, as messages ``run-slow``.
        timing: Whether runs are repeated as ``compare.timing_repeats`` says.
        resume: Keep the valid results in ``output`` and run the rest.
        max_runs: Refuse to expand to more runs; None: 10 000.
        progress: None: shown on a terminal or in a notebook, by tqdm if it is installed; True or False: shown or not;
            a function: called with each message of the batch, a dictionary as of ``--message-format json``.
        folder: Where relative paths of dictionaries start; None: the working directory.

    Raises:
        ScenarioError: A scenario, ``set`` or ``filter`` is invalid, or nothing is selected; nothing was run.
        RobotError: A robot is invalid; nothing was run.
        ResultsError: Results cannot be written, or another runner writes into ``output``.
        KeyboardInterrupt: Ctrl-C.
    """
    if resume and output is None:
        raise ValueError("resume=True needs output, the folder of the earlier results")
    files, overrides = native_inputs(collect(scenarios, folder), set)
    place = ResultsFolder.temporary() if output is None else ResultsFolder(output)
    options: dict[str, object] = {
        "output": str(place.path),
        "jobs": jobs,
        "log": log,
        "timeout": timeout,
        "max_fail": max_fail,
        "slow": slow,
        "timing": timing,
        "resume": resume,
        "max_runs": max_runs,
    }
    with Progress(progress) as shown:
        _native.run(files, overrides, filter, options, shown)
    counts = shown.counts
    complete = counts.finished >= counts.total and not counts.reference_refused
    return Results(place, complete=complete)
