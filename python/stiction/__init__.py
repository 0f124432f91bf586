"""Scenarios of legged-robot contact: run, read and step them from Python.

    results = stiction.run({"robot": {"model": stiction.robots() / "block/block.toml"}, "duration": 1.0})
    results.summary.to_pandas()

:func:`run` runs scenarios as the command ``runner`` does, with the same bits. :class:`Results` and :class:`Run` read
what it wrote. :class:`Simulation` and :class:`Batch` advance runs step by step. SI units, world axes; quaternions are
x, y, z, w.
"""

from stiction._errors import (
    Diagnostic,
    Error,
    LogError,
    ResultsError,
    RobotError,
    RunError,
    ScenarioError,
    ScenarioWarning,
)
from stiction._execution import run
from stiction._log import Event, Log
from stiction._native import VERSION as __version__
from stiction._native import Checkpoint, Contact, JointCommand, State, TaskContext
from stiction._resources import robots, scenarios
from stiction._results import Results, load
from stiction._run import Expectation, Run
from stiction._scenario import PlannedRun, Scenario
from stiction._simulation import Batch, Force, Simulation, Task
from stiction._table import Series, Summary, Table

__all__ = [
    "Batch",
    "Checkpoint",
    "Contact",
    "Diagnostic",
    "Error",
    "Event",
    "Expectation",
    "Force",
    "JointCommand",
    "Log",
    "LogError",
    "PlannedRun",
    "Results",
    "ResultsError",
    "RobotError",
    "Run",
    "RunError",
    "Scenario",
    "ScenarioError",
    "ScenarioWarning",
    "Series",
    "Simulation",
    "State",
    "Summary",
    "Table",
    "Task",
    "TaskContext",
    "__version__",
    "load",
    "robots",
    "run",
    "scenarios",
]
