"""Runs cases with this project's own `runner`: a scenario file per run, and its log as the series.

The program is the one of the environment variable STICTION_RUNNER, else `runner` of the path, else that of
target/release of this repository.
"""

import csv
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Unsupported
from stiction_engines.series import collected, rpy
from stiction_engines.urdf import joint_names, with_shapes

ADAPTIVE = (1e-4, 1e-6, 1e-8)
#: Records of adaptive runs, Hz; runs of fixed steps have one at each step.
RATE = 1e4


class Adapter(Engine):
    """This project's own simulator."""

    name = "stiction"
    package = "stiction"
    in_process = False

    def version(self):
        return _call("--version").split()[-1]

    def settings(self):
        fixed = "semi-implicit Euler, contact decided at the ends of steps"
        return [
            Settings(
                "exact", "exact friction, dopri5, contact tolerances of 1e-8", steps=ADAPTIVE, adaptive=True
            ),
            Settings(
                "default", "exact friction, dopri5, default contact tolerances", steps=ADAPTIVE, adaptive=True
            ),
            Settings("exact-fixed", f"exact friction, {fixed}"),
            Settings("one-step", f"one decision per contact and step, {fixed}"),
        ]

    def simulation(self, case, settings, step):
        raise NotImplementedError("it runs as a program of its own: `record` and `cost`")

    def record(self, case, settings, step):
        with tempfile.TemporaryDirectory() as folder:
            rate = RATE if settings.adaptive else 1.0 / step
            scenario = write_scenario(case, settings, step, Path(folder), rate)
            _run(scenario, folder)
            return _series(case, _robot(case), Path(folder))

    def cost(self, case, settings, step):
        with tempfile.TemporaryDirectory() as folder:
            _run(write_scenario(case, settings, step, Path(folder), 0), folder)
            with open(Path(folder) / "results/summary.csv", newline="") as file:
                row = next(csv.DictReader(file))
            return float(row["cpu_s"]), int(row["steps"])


def _program():
    given = os.environ.get("STICTION_RUNNER") or shutil.which("runner")
    if given:
        return given
    for folder in Path(__file__).resolve().parents:
        built = folder / "target/release/runner"
        if built.exists():
            return str(built)
    raise Unsupported("no `runner`: build it, or name it in STICTION_RUNNER")


def _call(*arguments, cwd=None):
    return subprocess.run(
        [_program(), *arguments], cwd=cwd, check=True, capture_output=True, text=True
    ).stdout


def _run(scenario, folder):
    command = [_program(), "run", str(scenario), "-j", "1", "-o", str(Path(folder) / "results")]
    ended = subprocess.run(command, capture_output=True, text=True)
    message = " ".join((ended.stderr or ended.stdout).split())
    if ended.returncode == 3:
        raise Failed(message[-300:])
    if ended.returncode != 0:
        raise RuntimeError(f"runner: exit code {ended.returncode}: {message[:250]}")


def _robot(case):
    """The body that becomes the scenario's robot, whose velocities are logged: that of the first measure."""
    return case.body(case.measures[0].body) if case.measures else case.bodies[0]


def _urdf(body, folder):
    """Writes the URDF with the body's shapes. Its points are left out: they become soles."""
    file = folder / f"{body.name}.urdf"
    file.write_text(with_shapes(body))
    return file.name


def _soles(body):
    """The points of links: one sole of up to four corners of a face, else a sole per point."""
    soles = []
    for link, shapes in body.touching.items():
        for shape in shapes:
            if shape.kind != "points":
                continue
            points = shape.points.tolist()
            # Feet of robots are faces; the points of a stool are far apart and touch singly.
            whole = len(body.joints) > 0 and len(points) > 2
            groups = [points] if whole else [[point] for point in points]
            soles += [
                {"name": f"{link}{len(soles) + i}", "link": link, "polygon": g} for i, g in enumerate(groups)
            ]
    return soles


def _toml(value):
    """A TOML value; JSON is TOML but for tables."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple, numpy.ndarray)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, bool) or not isinstance(value, (int, float, numpy.floating)):
        return json.dumps(value)
    return repr(float(value)) if not isinstance(value, int) else str(value)


def _placed(body):
    return {
        "position": body.position,
        "rpy": rpy(body.orientation),
        "linear_velocity": body.linear_velocity,
        "angular_velocity": body.angular_velocity,
    }


def _joint_table(body):
    """Drives by joint."""
    table = {}
    for joint in joint_names(body):
        servo = body.servos.get(joint)
        if servo and servo.target != body.joints.get(joint, 0.0):
            raise Unsupported("servos hold the posture of the start")
        drive = {"mode": "position", "kp": servo.kp, "kd": servo.kd} if servo else {"mode": "passive"}
        table[joint] = drive | {"armature": body.armature.get(joint, 0.0)}
    return table


def _forces(case, robot):
    """A force that is linear between instants, as the sum of ramps that last."""
    for force in case.forces:
        owner = {"link": force.link} | ({} if force.body == robot.name else {"object": force.body})
        if force.body != robot.name:
            owner.pop("link")
        common = owner | {"point": force.point}
        first = force.knots[0]
        if first[1:].any():
            yield common | {"type": "constant", "force": first[1:4], "moment": first[4:7], "start": first[0]}
        for before, after in zip(force.knots, force.knots[1:]):
            change = after[1:] - before[1:]
            if change.any():
                span = {"start": before[0], "duration": after[0] - before[0]}
                yield common | {"type": "ramp", "force": change[:3], "moment": change[3:]} | span
        last = force.knots[-1]
        if last[1:].any() and last[0] < case.duration:
            yield common | {"type": "constant", "force": -last[1:4], "moment": -last[4:7], "start": last[0]}


def write_scenario(case, settings, step, folder, rate):
    """Writes the scenario of a case and the files that it names. Returns its path."""
    if case.restitution != 0 and not settings.adaptive:
        raise Unsupported("fixed steps have no restitution")
    robot = _robot(case)
    points = _soles(robot)
    lines = [f"duration = {case.duration!r}", f"gravity = {_toml(case.gravity)}"]
    # Without points only links touch, with all of their shapes.
    base = {"base": _placed(robot), "model": _urdf(robot, folder), "soles": points}
    if points:
        base["contact"] = "soles"
    if robot.joints or robot.joint_velocities:
        base |= {"posture": robot.joints, "velocity": robot.joint_velocities, "joint": _joint_table(robot)}
    lines += ["[robot]", *(f"{key} = {_toml(value)}" for key, value in base.items())]

    on_floor = {body.name: case.floor_friction(body.name) for body in case.bodies}
    floor = next((f for f in on_floor.values() if f), None)
    if any(f and (f.static, f.kinetic) != (floor.static, floor.kinetic) for f in on_floor.values()):
        raise Unsupported("one friction of the floor")
    lines.append("[floor]")
    lines.append(
        f"friction = {_toml({'static': floor.static, 'kinetic': floor.kinetic})}"
        if floor
        else "plane = false"
    )
    for body in case.bodies:
        if body is robot:
            continue
        if any(s.kind == "points" for shapes in body.touching.values() for s in shapes):
            raise Unsupported("points of a second body")
        table = {"name": body.name, "type": "model", "model": _urdf(body, folder)} | _placed(body)
        lines += ["[[object]]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    label = lambda body: next(iter(body.touching)) if body is robot else body.name
    for friction in case.friction:
        if "floor" not in friction.bodies:
            pair = [label(case.body(name)) for name in friction.bodies]
            value = {"static": friction.static, "kinetic": friction.kinetic}
            lines += ["[[contact.pair]]", f"bodies = {_toml(pair)}", f"friction = {_toml(value)}"]
    for force in _forces(case, robot):
        lines += ["[[force]]", *(f"{key} = {_toml(value)}" for key, value in force.items())]

    contact = {
        "restitution": case.restitution,
        "method": "one-step" if settings.name == "one-step" else "exact",
    }
    if settings.name == "exact":
        contact |= {f"{quantity}_tolerance": 1e-8 for quantity in ("distance", "velocity", "acceleration")}
    integrator = {"method": "semi-implicit", "step": step}
    if settings.adaptive:
        integrator = {"method": "dopri5", "relative_tolerance": step, "absolute_tolerance": 1e-2 * step}
    lines += ["[contact]", *(f"{key} = {_toml(value)}" for key, value in contact.items())]
    lines += ["[integrator]", *(f"{key} = {_toml(value)}" for key, value in integrator.items())]
    lines += ["[log]", f"rate = {rate!r}", 'topics = ["state", "contact", "scene"]']
    file = folder / "case.toml"
    file.write_text("\n".join(lines) + "\n")
    return file


def _series(case, robot, folder):
    """The series of a run's log. Velocities of objects are differences of their logged positions."""
    (log,) = (folder / "results").rglob("log.mcap")
    table = folder / "series.csv"
    _call("export", str(log), "-o", str(table))
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    column = lambda name: numpy.array([float(row[name]) for row in rows])
    columns = lambda names: numpy.column_stack([column(name) for name in names])
    time = column("time_s")
    bodies = []
    for body in case.bodies:
        if body is robot:
            joints = joint_names(body)
            nothing = numpy.zeros((len(rows), 0))
            bodies.append(
                (
                    columns([f"base_{axis}_m" for axis in "xyz"]),
                    columns([f"base_q{part}" for part in "wxyz"]),
                    columns([f"base_v{axis}_m_s" for axis in "xyz"]),
                    columns([f"base_w{axis}_rad_s" for axis in "xyz"]),
                    columns([f"joint.{name}.position_rad" for name in joints]) if joints else nothing,
                    columns([f"joint.{name}.velocity_rad_s" for name in joints]) if joints else nothing,
                )
            )
        else:
            place = columns([f"object.{body.name}.{axis}_m" for axis in "xyz"])
            angles = columns([f"object.{body.name}.{angle}_rad" for angle in ("roll", "pitch", "yaw")])
            slope = lambda values: numpy.gradient(values, time, axis=0)
            nothing = numpy.zeros((len(rows), 0))
            bodies.append((place, _quaternions(angles), slope(place), slope(angles), nothing, nothing))
    states = [[BodyState(*(values[k] for values in body)) for body in bodies] for k in range(len(rows))]
    return collected(case, time, states)


def _quaternions(angles):
    (sr, sp, sy), (cr, cp, cy) = numpy.sin(angles.T / 2), numpy.cos(angles.T / 2)
    return numpy.column_stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )
