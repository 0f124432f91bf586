"""A case: bodies on a floor, forces in time, what is measured and what is true.

World axes with z up; SI units; quaternions w, x, y, z. The floor is the plane z = 0. A slope is a case whose
gravity is tilted.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy

FORMAT = "stiction-case-1"


class CaseError(Exception):
    """A case that cannot be read: file, key, value seen and value wanted."""


@dataclass(frozen=True)
class Shape:
    """What touches, in the frame of its link.

    `kind` is `box` (edges `size`), `sphere` (`radius`), `cylinder` (`radius`, `length`, axis z) or `points`
    (`points`: single points of contact, such as the corners of a foot).
    """

    kind: str
    position: numpy.ndarray
    orientation: numpy.ndarray
    size: numpy.ndarray | None = None
    radius: float | None = None
    length: float | None = None
    points: numpy.ndarray | None = None


@dataclass(frozen=True)
class Servo:
    """A drive: effort = kp (target - q) - kd dq/dt, without limits, continuous in time."""

    kp: float
    kd: float
    target: float


@dataclass(frozen=True)
class Body:
    """A URDF on a floating joint. Position, orientation and velocities are those of its root link's frame.

    The URDF has inertias and joints only: no shapes, limits, damping or friction of joints. Joints that `joints` and
    `joint_velocities` leave out start at 0. `armature` is the inertia of a joint's rotor, seen at the joint, kg m^2:
    it adds to the diagonal of the mass matrix. `touching` has the shapes by link; nothing else touches.
    """

    name: str
    urdf: Path
    position: numpy.ndarray
    orientation: numpy.ndarray
    linear_velocity: numpy.ndarray
    angular_velocity: numpy.ndarray
    joints: dict[str, float]
    joint_velocities: dict[str, float]
    armature: dict[str, float]
    servos: dict[str, Servo]
    touching: dict[str, list[Shape]]


@dataclass(frozen=True)
class Force:
    """A force and a moment on a link, world axes, linear between instants and zero outside of them.

    `knots` has rows of time, force x y z, moment x y z. The force acts at `point`, which is fixed in the link.
    """

    body: str
    link: str
    point: numpy.ndarray
    knots: numpy.ndarray

    def at(self, time):
        """Force and moment at `time`."""
        times = self.knots[:, 0]
        if time < times[0] or time > times[-1]:
            return numpy.zeros(3), numpy.zeros(3)
        values = [numpy.interp(time, times, self.knots[:, 1 + k]) for k in range(6)]
        return numpy.array(values[:3]), numpy.array(values[3:])


@dataclass(frozen=True)
class Friction:
    """Coulomb friction of two bodies, or of a body and the floor (`floor`). Pairs that no case names do not touch."""

    bodies: tuple[str, str]
    static: float
    kinetic: float


@dataclass(frozen=True)
class Measure:
    """What is measured, as `measure.py` defines its `kind`, and its truth with the error of the truth itself."""

    name: str
    kind: str
    body: str | None
    unit: str
    truth: float
    truth_error: float
    derivation: str
    parameters: dict


@dataclass(frozen=True)
class Case:
    """A case. `restitution` is the coefficient of all contacts."""

    name: str
    title: str
    family: str
    gravity: numpy.ndarray
    restitution: float
    bodies: list[Body]
    friction: list[Friction]
    forces: list[Force]
    duration: float
    measures: list[Measure]
    file: Path = field(compare=False)

    def body(self, name):
        """The body of this name."""
        return next(body for body in self.bodies if body.name == name)

    def floor_friction(self, name):
        """Friction of a body with the floor; none if they do not touch."""
        return next((f for f in self.friction if set(f.bodies) == {"floor", name}), None)

    @property
    def has_two_coefficients(self):
        """True if static and kinetic friction differ somewhere."""
        return any(f.static != f.kinetic for f in self.friction)


def _vector(value):
    return numpy.array(value, dtype=float)


def _shape(data):
    optional = lambda key: _vector(data[key]) if key in data else None
    return Shape(
        kind=data["kind"],
        position=_vector(data.get("position", [0, 0, 0])),
        orientation=_vector(data.get("orientation", [1, 0, 0, 0])),
        size=optional("size"),
        radius=data.get("radius"),
        length=data.get("length"),
        points=optional("points"),
    )


def _body(data, folder):
    return Body(
        name=data["name"],
        urdf=folder / data["urdf"],
        position=_vector(data["position"]),
        orientation=_vector(data.get("orientation", [1, 0, 0, 0])),
        linear_velocity=_vector(data.get("linear_velocity", [0, 0, 0])),
        angular_velocity=_vector(data.get("angular_velocity", [0, 0, 0])),
        joints=dict(data.get("joints", {})),
        joint_velocities=dict(data.get("joint_velocities", {})),
        armature=dict(data.get("armature", {})),
        servos={name: Servo(**servo) for name, servo in data.get("servos", {}).items()},
        touching={link: [_shape(s) for s in shapes] for link, shapes in data.get("touching", {}).items()},
    )


def _measure(data):
    keys = ["name", "kind", "unit", "truth", "truth_error", "derivation"]
    parameters = {key: value for key, value in data.items() if key not in [*keys, "body"]}
    return Measure(**{key: data[key] for key in keys}, body=data.get("body"), parameters=parameters)


def read(file):
    """Reads a case. Raises `CaseError`."""
    file = Path(file)
    try:
        data = json.loads(file.read_text())
        if data["format"] != FORMAT:
            raise CaseError(f"{file}: `format` is {data['format']!r}, expected {FORMAT!r}")
        return Case(
            name=data["name"],
            title=data["title"],
            family=data["family"],
            gravity=_vector(data["gravity"]),
            restitution=data.get("restitution", 0.0),
            bodies=[_body(body, file.parent) for body in data["bodies"]],
            friction=[Friction(tuple(f["bodies"]), f["static"], f["kinetic"]) for f in data["friction"]],
            forces=[Force(f["body"], f["link"], _vector(f["point"]), _vector(f["knots"])) for f in data["forces"]],
            duration=data["duration"],
            measures=[_measure(m) for m in data["measures"]],
            file=file,
        )
    except OSError as error:
        raise CaseError(f"{file}: {error.strerror}") from error
    except json.JSONDecodeError as error:
        raise CaseError(f"{file}: line {error.lineno}: {error.msg}") from error
    except KeyError as error:
        raise CaseError(f"{file}: the key {error} is missing") from error
    except (TypeError, ValueError) as error:
        raise CaseError(f"{file}: {error}") from error


def folder():
    """The folder of the cases of this package."""
    return Path(__file__).parent / "cases"


def read_all(names=()):
    """All cases, or those whose name contains one of `names`, by name."""
    files = sorted(folder().glob("*.json"))
    files = [f for f in files if not f.name.endswith(".schema.json")]
    return [read(f) for f in files if not names or any(name in f.stem for name in names)]
