"""What an adapter of an engine implements.

An adapter is one file of `adapters` with a class `Adapter`. It builds a `Simulation` of a case, which the other
modules step and read. It changes nothing of a case: what its engine cannot express raises `Unsupported` with the
reason, which the table of results then shows.
"""

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy

from .series import Failed, recorded, steps_of

__all__ = ["BodyState", "Engine", "Failed", "Settings", "Simulation", "Unsupported"]

#: Interval at which an adaptive engine is asked for its state, s.
REPORT = 1e-3


class Unsupported(Exception):
    """The engine cannot express the case; the text says what of it."""


@dataclass(frozen=True)
class Settings:
    """A choice of options of an engine. `name` is a word, `description` is for readers.

    `steps` are lengths of fixed steps in s, or, if `adaptive`, relative tolerances.
    """

    name: str
    description: str
    steps: tuple[float, ...] = (4e-3, 1e-3, 2.5e-4)
    adaptive: bool = False


@dataclass
class BodyState:
    """State of a body: frame of its root link in the world, velocity of that origin, angular velocity in world axes.

    `q` and `qd` are in the order of the body's joints in its URDF, fixed ones left out.
    """

    position: numpy.ndarray
    orientation: numpy.ndarray
    linear_velocity: numpy.ndarray
    angular_velocity: numpy.ndarray
    q: numpy.ndarray
    qd: numpy.ndarray


class Simulation(ABC):
    """A case in an engine, at its start."""

    @property
    @abstractmethod
    def time(self):
        """Simulated time, s."""

    @abstractmethod
    def advance(self, steps):
        """Takes `steps` steps. Forces of the case that change with time are taken at the start of each step, or as
        the engine does it best. An adaptive engine takes steps of 1 ms, inside of which it chooses its own."""

    @abstractmethod
    def states(self):
        """A `BodyState` per body of the case, in its order."""


class Engine(ABC):
    """An engine."""

    #: Name in the tables.
    name: str
    #: The package that pip installs.
    package: str
    #: False if it runs as a program of its own; then it has its own `record` and `cost` instead of `simulation`.
    in_process = True

    @abstractmethod
    def version(self):
        """Version of the engine."""

    @abstractmethod
    def settings(self):
        """Choices of options: the engine's defaults, and those known as its most accurate."""

    @abstractmethod
    def simulation(self, case, settings, step):
        """A `Simulation` of the case. Raises `Unsupported`."""

    def record(self, case, settings, step):
        """The series of a run over the duration of the case. Raises `Unsupported` or `Failed`."""
        interval = REPORT if settings.adaptive else step
        return recorded(case, self.simulation(case, settings, step), interval)

    def cost(self, case, settings, step):
        """Processor time of a run without its set-up, s, and the number of its steps."""
        simulation = self.simulation(case, settings, step)
        steps = steps_of(case, REPORT if settings.adaptive else step)
        begin = time.process_time()
        simulation.advance(steps)
        return time.process_time() - begin, steps
