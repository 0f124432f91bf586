"""Simulations that are stepped, and tasks and forces in Python."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction import _native
from stiction._execution import native_inputs
from stiction._scenario import ScenarioLike, scenario_of

TaskFunction: TypeAlias = "Callable[[_native.TaskContext, _native.JointCommand], bool | None]"
ForceFunction: TypeAlias = "Callable[[float, NDArray[np.float64], NDArray[np.float64]], ArrayLike]"


@dataclass(frozen=True)
class Task:
    """A task in Python: it commands the joints at each control tick.

    Where tasks overlap in time, the later one commands a joint; those of the scenario come first.

    Attributes:
        function: Called with a :class:`TaskContext`, the robot as sensed and estimated, and a :class:`JointCommand`,
            whose arrays it writes. It returns None or True to continue, False to end. Both arguments are valid during
            the call only.
        name: Name in events and messages; None: that of the function.
        start: Simulated time of the first call, s.
        needs: Attributes of the context to compute for it: ``com``, ``com_velocity``, ``com_jacobian``,
            ``mass_matrix``, ``bias``, ``gravity_effort``, ``sole_forces``, ``sole_moments``, ``zmp``,
            ``support_polygon``, ``link_poses``.
    """

    function: TaskFunction
    name: str | None = None
    start: float = 0.0
    needs: Sequence[str] = ()

    def _native(self) -> tuple[str, TaskFunction, float, list[str]]:
        _check(self.function, "a task")
        return self.name or _name(self.function), self.function, float(self.start), list(self.needs)


@dataclass(frozen=True)
class Force:
    """An external force in Python, at a point of a link.

    The integrator evaluates forces at any time and state, in any order, and takes steps back. The function must be
    one of time and state alone; otherwise the run depends on the order of its calls.

    Attributes:
        function: Called with the time (s), and position (m) and velocity (m/s) of the point, arrays of shape (3,) in
            world axes. It returns the force (N), shape (3,), or force and moment (N m), shape (6,), world axes.
        link: Name of the link.
        point: The point in the link's frame, m.
        name: Name; None: that of the function.
        corners: Times at which the force jumps or has a kink, s; steps end there.
    """

    function: ForceFunction
    link: str
    point: Sequence[float] = (0.0, 0.0, 0.0)
    name: str | None = None
    corners: Sequence[float] = ()

    def _native(self) -> tuple[str, str, ForceFunction, list[float], list[float]]:
        name = self.name or _name(self.function)
        return name, self.link, self.function, [float(x) for x in self.point], [float(time) for time in self.corners]


def _check(function: object, what: str) -> None:
    """Refuses what is no function, and functions whose call would do nothing."""
    if not callable(function):
        raise TypeError(f"{what}: found {function!r}, expected a function")
    if inspect.isgeneratorfunction(function) or inspect.iscoroutinefunction(function):
        raise TypeError(f"{what}: {_name(function)} is a generator or coroutine function, expected a plain function")


def _name(function: Callable[..., Any]) -> str:
    return getattr(function, "__name__", type(function).__name__)


class Simulation(_native.Simulation):
    """One run of a scenario, advanced step by step. SI units, world axes; quaternions are x, y, z, w.

    Args:
        scenario: A path, a dictionary with the keys of a scenario file, or a :class:`stiction.Scenario`.
        run: Index of the run among those that the scenario expands to, from 0.
        set: Values by dotted key, as of ``--set``.
        tasks: Tasks in Python: :class:`Task`, or functions that start at 0.
        forces: External forces in Python.
        log: File of a log (``.mcap``), complete when the run ends or the simulation is deleted; None: no log.

    Raises:
        ScenarioError: The scenario or ``set`` is invalid.
        RobotError: The robot is invalid.
        IndexError: The scenario has no such run.
        ValueError: The robot has no such link, or ``needs`` an unknown name.
        ResultsError: The log cannot be written.
        RunError: The run cannot start.
    """

    def __new__(
        cls,
        scenario: ScenarioLike,
        *,
        run: int = 0,
        set: Mapping[str, object] | None = None,
        tasks: Iterable[Task | TaskFunction] = (),
        forces: Iterable[Force] = (),
        log: str | os.PathLike[str] | None = None,
    ) -> Self:
        (file,), overrides = native_inputs([scenario_of(scenario)], set)
        acting = list(forces)
        for force in acting:
            if not isinstance(force, Force):
                raise TypeError(f"forces: found {force!r}, expected stiction.Force(function, link)")
        listed = [task if isinstance(task, Task) else Task(task) for task in tasks]
        return super().__new__(
            cls,
            file,
            overrides,
            run,
            [task._native() for task in listed],
            [force._native() for force in acting],
            None if log is None else os.fspath(log),
        )

    # The arguments are those of `__new__`.
    def __init__(self, *_: object, **__: object) -> None:
        pass

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle a Simulation: pickle its Scenario and step again, or use save() in one process")

    def __repr__(self) -> str:
        return f"Simulation(key={self.key!r}, time={self.time:.6g} s of {self.end:.6g} s)"


class Batch(_native.Batch):
    """Simulations that are stepped together, in parallel and without the global interpreter lock.

    All simulations must have equally many joints. Each gives the bits that it gives alone.

    Args:
        simulations: The simulations, m of them.
        jobs: Threads; None: one per processor.
    """

    def __new__(cls, simulations: Iterable[_native.Simulation], jobs: int | None = None) -> Self:
        return super().__new__(cls, list(simulations), jobs)

    # The arguments are those of `__new__`.
    def __init__(self, *_: object, **__: object) -> None:
        pass

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle a Batch: pickle the scenarios of its simulations")

    def __repr__(self) -> str:
        return f"Batch({len(self)} simulations)"
