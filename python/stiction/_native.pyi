"""The native module: scenarios, batches, logs and simulations in Rust.

SI units, world axes, quaternions x, y, z, w. n is the number of joints, in the order of ``joint_names``. All functions
and methods may raise the errors of :mod:`stiction`.
"""

from collections.abc import Callable
from typing import Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
Overrides: TypeAlias = list[tuple[str, object]]
Mode: TypeAlias = Literal["position", "velocity", "force", "kinematic", "passive"]

VERSION: str

def main(launcher: str, arguments: list[str]) -> int:
    """Runs the command ``runner`` and returns its exit code.

    Args:
        launcher: Path of a program that starts the command again.
        arguments: Arguments without the program's name.
    """

class ScenarioFile:
    """A scenario file with overrides."""

    name: str
    """Name of the scenario."""
    path: str
    """Path in messages; relative paths start at its folder."""
    text: str
    """TOML text."""

    @staticmethod
    def load(path: str) -> ScenarioFile:
        """Reads a file.

        Raises:
            ScenarioError: It cannot be read or is not TOML.
        """

    @staticmethod
    def parse(path: str, text: str) -> ScenarioFile:
        """Reads TOML text; ``path`` need not exist.

        Raises:
            ScenarioError: It is not TOML.
        """

    @staticmethod
    def from_dict(path: str, values: dict[str, object]) -> ScenarioFile:
        """Reads dictionaries, lists, tuples, strings, numbers, booleans, paths, NumPy scalars and arrays.

        Raises:
            TypeError: A value has another type.
        """

    def with_overrides(self, overrides: Overrides) -> ScenarioFile:
        """Returns a copy with further overrides of its own, which precede those of a call."""

def runs(
    files: list[ScenarioFile], overrides: Overrides, filter: str | None, max_runs: int | None
) -> list[dict[str, Any]]:
    """Returns the runs: ``scenario``, ``key``, ``label``, ``seed``, ``parameters``.

    Raises:
        ScenarioError: A scenario, an override or the filter is invalid.
    """

def check(files: list[ScenarioFile], overrides: Overrides, filter: str | None) -> list[dict[str, Any]]:
    """Returns all diagnostics: ``severity``, ``message``, ``file``, ``line``, ``column``, ``key``, ``help``,
    ``rendered``."""

def run(
    files: list[ScenarioFile],
    overrides: Overrides,
    filter: str | None,
    options: dict[str, object],
    on_message: Callable[[dict[str, Any]], None] | None,
) -> None:
    """Runs scenarios without the global interpreter lock and writes their results.

    Args:
        files: Scenarios.
        overrides: Values by dotted key.
        filter: Condition that selects runs.
        options: ``output``, ``jobs``, ``log``, ``timeout``, ``max_fail``, ``slow``, ``timing``, ``resume``,
            ``max_runs``.
        on_message: Called with each message of the batch.

    Raises:
        ScenarioError: Invalid input; nothing was run.
        ResultsError: Results cannot be written.
        KeyboardInterrupt: Ctrl-C; active runs are cancelled.
    """

def summary(folder: str) -> Table:
    """Reads ``summary.parquet`` of a folder.

    Raises:
        ResultsError: It is missing or cannot be read.
    """

def columns(log: str) -> list[str]:
    """Returns the names of the columns of a log's time series.

    Raises:
        LogError: The log cannot be read.
    """

def series(log: str, columns: list[str], rate: float | None, start: float | None, end: float | None) -> Table:
    """Reads time series; the first column is ``time_s``. ``columns`` may have the wildcards ``*`` and ``?``.

    Raises:
        LogError: The log cannot be read, or a name matches no column.
    """

def events(log: str) -> Table:
    """Reads the events of a log: ``time_s``, ``kind``, ``subject``, ``message``.

    Raises:
        LogError: The log cannot be read.
    """

def report(folder: str) -> str:
    """Rewrites summary and report from the records and returns the path of the report.

    Raises:
        ResultsError: There are no records, or a file cannot be written.
    """

class Table:
    """Columns of equal length."""

    column_names: list[str]
    """Names, in order."""
    rows: int
    """Number of rows."""

    def column(self, name: str) -> NDArray[Any] | list[str | None] | list[bool | None]:
        """Returns numbers or flags as a new array of shape (rows,), other values as a list. Missing numbers are NaN."""

    def __len__(self) -> int: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class TaskContext:
    """The robot as a task reads it, at a control tick: base as estimated, joints as sensed.

    Attributes that the task does not name in ``needs`` raise AttributeError. nv is the number of velocities: six of a
    floating base (linear, angular), then the joints.
    """

    start: float
    """Start of the task, s."""
    time: float
    """Simulated time, s."""
    q: Array
    """Joint positions, rad or m, (n,)."""
    qd: Array
    """Joint velocities, rad/s or m/s, (n,)."""
    effort: Array
    """Efforts of the actuators, N m or N, (n,)."""
    base_position: Array
    """Origin of the root link's frame, m, (3,)."""
    base_orientation: Array
    """Quaternion of the root link's frame, x, y, z, w, (4,)."""
    base_linear_velocity: Array
    """Velocity of that origin, m/s, (3,); zero for a fixed base."""
    base_angular_velocity: Array
    """Angular velocity of the root link, rad/s, (3,); zero for a fixed base."""
    com: Array
    """Centre of mass, m, (3,)."""
    com_velocity: Array
    """Its velocity, m/s, (3,)."""
    com_jacobian: Array
    """Its Jacobian, (3, nv)."""
    mass_matrix: Array
    """Mass matrix M of M v' + h = tau, (nv, nv)."""
    bias: Array
    """Bias h: Coriolis, centrifugal and gravity terms, (nv,)."""
    gravity_effort: Array
    """Generalised force against gravity, (nv,)."""
    sole_forces: Array
    """Force of the floor on each sole at the tick before, N, (soles, 3)."""
    sole_moments: Array
    """Its moment about the mean of the sole's vertices, N m, (soles, 3)."""
    zmp: Array | None
    """Zero-moment point, m, (3,); None when nothing presses on the floor."""
    support_polygon: Array
    """Corners of the support polygon, m, (k, 3)."""
    link_poses: dict[str, tuple[Array, Array]]
    """Position (3,) and quaternion (4,) of the frame of each link, by name."""

class JointCommand:
    """The joint commands of a tick, with those of earlier tasks. Values that a task does not set stay."""

    position: Array
    """Desired positions, rad or m, (n,); writable."""
    velocity: Array
    """Desired velocities, (n,); writable."""
    effort: Array
    """Efforts in mode ``force``, feed-forward efforts in the others, N m or N, (n,); writable."""
    kp: Array
    """Position gains, N m/rad or N/m, (n,); writable."""
    kd: Array
    """Velocity gains, N m s/rad or N s/m, (n,); writable."""
    mode: list[Mode]
    """Modes of the drives."""

class State:
    """The state of a simulation at one instant."""

    time: float
    """Simulated time, s."""
    base_position: Array
    """Origin of the root link's frame, m, (3,)."""
    base_orientation: Array
    """Quaternion of the root link's frame, x, y, z, w, (4,)."""
    base_linear_velocity: Array
    """Velocity of that origin, m/s, (3,)."""
    base_angular_velocity: Array
    """Angular velocity of the root link, rad/s, (3,)."""
    q: Array
    """Joint positions, rad or m, (n,)."""
    qd: Array
    """Joint velocities, (n,)."""
    effort: Array
    """Efforts of the actuators, without friction and stops, N m or N, (n,)."""

class Contact:
    """A contact: of a sole, of a link with the floor, or of a pair of bodies. k is the number of its points."""

    name: str
    """Name of the sole, the link or the pair."""
    state: str
    """``"free"``, or pattern and mode, such as ``"face-static"``."""
    is_closed: bool
    """Whether a point touches."""
    points: Array
    """Positions of vertices, m, (k, 3)."""
    velocities: Array
    """Their velocities, m/s, (k, 3)."""
    forces: Array
    """Forces on them, N, (k, 3); of a pair those on the first body."""
    clamped: Flags
    """Which of them touch, (k,)."""

class Checkpoint:
    """A saved state of a simulation; see :meth:`Simulation.save`."""

    time: float
    """Simulated time, s."""

class Simulation:
    """One run, stepped."""

    def __new__(
        cls,
        file: ScenarioFile,
        overrides: Overrides,
        run: int,
        tasks: list[tuple[str, Callable[..., Any], float, list[str]]],
        forces: list[tuple[str, str, Callable[..., Any], list[float], list[float]]],
        log: str | None,
    ) -> Self: ...
    @property
    def key(self) -> str:
        """Key of the run."""

    @property
    def time(self) -> float:
        """Simulated time, s."""

    @property
    def end(self) -> float:
        """Simulated time at which the run ends at the latest, s."""

    @property
    def tick(self) -> float:
        """Time between two control ticks, s."""

    @property
    def has_ended(self) -> bool:
        """Whether the run has ended, at its end or early."""

    @property
    def outcome(self) -> str | None:
        """Outcome of a run that has ended, such as ``"passed"``; None before. Expectations are not evaluated."""

    @property
    def message(self) -> str:
        """Why the run ended early; empty if it did not."""

    @property
    def notes(self) -> list[str]:
        """Notes on the run."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints, n of them."""

    @property
    def link_names(self) -> list[str]:
        """Names of the links."""

    @property
    def sole_names(self) -> list[str]:
        """Names of the soles."""

    @property
    def mass(self) -> float:
        """Mass of the robot, kg."""

    def step(self, ticks: int = 1) -> bool:
        """Advances by control ticks, which then end steps of the integrator. Returns whether the run continues.

        Raises:
            RunError: The run ended early, such as a diverged or fallen one.
            Exception: Whatever a task or force in Python raised.
        """

    def step_once(self) -> bool:
        """Takes one step of the integrator. Returns whether the run continues; errors as of :meth:`step`."""

    def advance_to(self, time: float) -> bool:
        """Advances to the first end of a step at or after a time, s. Returns whether the run continues.

        Raises:
            RunError: The run ended early.
            KeyboardInterrupt: Ctrl-C; the run is cancelled.
        """

    def run(self) -> str:
        """Advances to the end and returns the outcome; an early end raises nothing.

        Raises:
            KeyboardInterrupt: Ctrl-C; the run is cancelled.
        """

    @property
    def state(self) -> State:
        """The present state."""

    @property
    def contacts(self) -> list[Contact]:
        """Contacts of all soles, then of links and pairs that touch or are about to."""

    def snapshot(self) -> dict[str, Any]:
        """Returns further quantities of the present instant.

        ``time`` (s), ``com`` (m), ``com_velocity`` (m/s) and ``centre_of_pressure`` (m; None in flight) of shape (3,),
        and two dictionaries of numbers: ``energy`` (J: ``change``, ``actuators``, ``external``, ``joint_loss``,
        ``friction_loss``, ``impact_loss``, ``error``) and ``residual`` (``penetration``, ``tension``, ``signorini``,
        ``cone_excess``, ``dissipation_gap``, ``creep_speed``, ``resultant_gap``).
        """

    @property
    def metrics(self) -> dict[str, float]:
        """Metrics so far, by the names of the summary's columns, without those that were not measured.

        Those computed at the end of the run, such as ``final_base_x``, are NaN before.
        """

    @property
    def events(self) -> list[tuple[float, str, str, str]]:
        """Events so far: time (s), kind, subject, message."""

    def command(
        self,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        effort: ArrayLike | None = None,
        kp: ArrayLike | None = None,
        kd: ArrayLike | None = None,
        mode: Mode | list[Mode] | None = None,
    ) -> None:
        """Commands the joints from the next control tick on, which after :meth:`step` is now.

        The values hold until the next call. Values that are None are left to the tasks.

        Args:
            position: Desired positions, rad or m, (n,).
            velocity: Desired velocities, rad/s or m/s, (n,).
            effort: Efforts in mode ``force``, feed-forward efforts in the others, N m or N, (n,).
            kp: Position gains, N m/rad or N/m, (n,).
            kd: Velocity gains, N m s/rad or N s/m, (n,).
            mode: Modes of the drives, one for all or one for each joint.

        Raises:
            ValueError: An array has another length, or there is no such mode.
        """

    def save(self) -> Checkpoint:
        """Saves the exact state, also the time. Control ticks end steps of the integrator from then on.

        Raises:
            RunError: Errors of sensors, estimators or scripts of forces have memory that cannot be saved.
        """

    def restore(self, checkpoint: Checkpoint) -> None:
        """Returns to a saved state of this run; from there it gives equal bits.

        Raises:
            RunError: The checkpoint is of another run, the run writes a log, an event of the scenario happened since,
                or a task of the scenario depends on its earlier calls. The state is then unchanged.
        """

class Batch:
    """Simulations that are stepped together. m is their number, n the number of joints of each."""

    def __new__(cls, simulations: list[Simulation], jobs: int | None) -> Self: ...
    def __len__(self) -> int: ...
    @property
    def simulations(self) -> list[Simulation]:
        """The simulations, in the order of the rows."""

    def step(self, ticks: int = 1) -> None:
        """Sends ``position``, ``velocity`` and ``effort``, advances all by control ticks, refreshes the other arrays.

        Runs that have ended stay as they are.

        Raises:
            RunError: A run ended early; raised after all were stepped.
        """

    def refresh(self) -> None:
        """Reads the motion of all simulations again, such as after one was restored."""

    time: Array
    """Simulated times, s, (m,)."""
    q: Array
    """Joint positions, rad or m, (m, n)."""
    qd: Array
    """Joint velocities, (m, n)."""
    base_position: Array
    """Origins of the root links' frames, m, (m, 3)."""
    base_orientation: Array
    """Quaternions of the root links' frames, (m, 4)."""
    base_linear_velocity: Array
    """Velocities of these origins, m/s, (m, 3)."""
    base_angular_velocity: Array
    """Angular velocities of the root links, rad/s, (m, 3)."""
    position: Array
    """Desired positions of the next step, (m, n); writable."""
    velocity: Array
    """Desired velocities of the next step, (m, n); writable."""
    effort: Array
    """Efforts of the next step, in mode ``force``; feed-forward efforts in the others, (m, n); writable."""
    has_ended: Flags
    """Which runs have reached their end, (m,)."""
