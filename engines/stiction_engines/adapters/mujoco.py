"""Runs cases in MuJoCo.

A case becomes an `MjSpec`: the URDF of each body on a free joint, a geom per shape, and explicit contact
pairs, so nothing else touches. Masses, inertias and joints are those of the URDF.
"""

import itertools
import math
from dataclasses import dataclass

import mujoco
import numpy

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported
from stiction_engines.urdf import joint_names

# Radius of the sphere that stands for a point of contact, m. Its lowest point is the point where the link
# is level; where the link tilts by an angle a, it is lower by r (1 - cos a).
POINT_RADIUS = 1e-6
# Warnings of MuJoCo that a state is not finite or above 1e10.
DIVERGED = [
    mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC,
]


@dataclass(frozen=True)
class Options:
    """Options of MuJoCo for one of the settings. None leaves a value to MuJoCo.

    `solref_steps`: time constant of contacts along their normal, in steps. `friction_time`: time constant
    along the plane of contact at a step of 1 ms, s; it is proportional to the root of the step. `impedance`:
    dmin and dmax of solimp.
    """

    cone: mujoco.mjtCone
    integrator: mujoco.mjtIntegrator
    solref_steps: float | None = None
    friction_time: float | None = None
    impedance: float | None = None
    impratio: float = 1.0
    iterations: int | None = None
    tolerance: float | None = None

    def apply(self, option, step):
        """Sets the options of a spec."""
        option.timestep = step
        option.cone = self.cone
        option.integrator = self.integrator
        option.impratio = self.impratio
        if self.iterations is not None:
            option.iterations = self.iterations
            option.ls_iterations = self.iterations
        if self.tolerance is not None:
            option.tolerance = self.tolerance


# Choices of "accurate", measured on the cases of this package:
# - Elliptic cone: with the pyramid of the default a box slides 41 % too far at 45 degrees to its sides,
#   with this one 0.2 % short at 1 ms, which is the error of the integrator.
# - solref 4 steps, impedance 0.95: with 2 steps, the least that MuJoCo takes, contacts chatter, and a box
#   that slides at 22.5 degrees goes 1.7 % too far at 1 ms instead of 0.3 %. With 8 steps the quadruped
#   sinks in by 0.4 mm instead of 0.1 mm. With an impedance of 0.99 it walks away by 5 cm at 4 ms.
# - solreffriction: MuJoCo's friction is a convex relaxation, which lifts a sliding body by a speed mu |v| 2
#   h / t with this time constant t. With t = 2 h a box at 6 m/s hops 0.3 m at any step. A longer t makes
#   friction viscous below mu g t / 2. At 1 ms, t = 10 ms hops 13 mm and stops 10 ms late; its root lets
#   both vanish with the step.
# - impratio 100: on a slope of 23 degrees a box creeps by 0.02 mm in 1 s. noslip iterations make it
#   0.018 mm, change no other figure and cost 20 % or more.
OPTIONS = {
    "default": Options(mujoco.mjtCone.mjCONE_PYRAMIDAL, mujoco.mjtIntegrator.mjINT_EULER),
    "accurate": Options(
        mujoco.mjtCone.mjCONE_ELLIPTIC,
        mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
        solref_steps=4.0,
        friction_time=0.01,
        impedance=0.95,
        impratio=100.0,
        iterations=200,
        tolerance=1e-12,
    ),
}

SETTINGS = [
    Settings("default", "MuJoCo's defaults: pyramidal cone, Euler, soft contacts (solref 0.02 1)"),
    Settings("accurate", "elliptic cone, implicitfast, solref of 4 steps, softer friction, impratio 100"),
]


def unsupported(case):
    """Raises `Unsupported` for what MuJoCo cannot express."""
    if case.has_two_coefficients:
        raise Unsupported("one coefficient of friction: static and kinetic friction cannot differ")
    if case.restitution != 0.0:
        raise Unsupported("no coefficient of restitution: contacts are damped springs")


def geoms(body, shape):
    """Arguments of `add_geom` for a shape in the frame of its link."""
    kinds = mujoco.mjtGeom
    if shape.kind == "points":
        rotation = numpy.zeros(9)
        mujoco.mju_quat2Mat(rotation, shape.orientation)
        for point in shape.points:
            centre = shape.position + rotation.reshape(3, 3) @ point + [0.0, 0.0, POINT_RADIUS]
            yield {"type": kinds.mjGEOM_SPHERE, "size": [POINT_RADIUS, 0, 0], "pos": centre}
        return
    types = {
        "box": lambda: (kinds.mjGEOM_BOX, shape.size / 2),
        "sphere": lambda: (kinds.mjGEOM_SPHERE, [shape.radius, 0, 0]),
        "cylinder": lambda: (kinds.mjGEOM_CYLINDER, [shape.radius, shape.length / 2, 0]),
    }
    if shape.kind not in types:
        raise Unsupported(f"no shape {shape.kind!r} (body {body.name})")
    kind, size = types[shape.kind]()
    yield {"type": kind, "size": size, "pos": shape.position, "quat": shape.orientation}


def add_body(spec, body):
    """Adds a body with its shapes, rotors and servos. Returns the names of its geoms and joints."""
    child = mujoco.MjSpec.from_file(str(body.urdf))
    child.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    # Links on fixed joints stay bodies of their own, so that shapes and forces find them by name.
    child.compiler.fusestatic = False
    names, prefix = [], f"{body.name}/"
    for link, shapes in body.touching.items():
        for arguments in itertools.chain.from_iterable(geoms(body, shape) for shape in shapes):
            name = f"{link}/{len(names)}"
            # Contacts come from explicit pairs alone.
            child.body(link).add_geom(name=name, mass=0, contype=0, conaffinity=0, **arguments)
            names.append(prefix + name)
    # MuJoCo sorts joints along the tree, not as the URDF does.
    joints = joint_names(body)
    for joint in child.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.armature = body.armature.get(joint.name, 0.0)
    child.worldbody.first_body().add_freejoint(name="free")
    spec.attach(child, prefix=prefix, frame=spec.worldbody.add_frame())
    for joint, servo in body.servos.items():
        actuator = spec.add_actuator(
            name=prefix + joint, target=prefix + joint, trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED, biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )
        actuator.gainprm[0] = servo.kp
        actuator.biasprm[1], actuator.biasprm[2] = -servo.kp, -servo.kd
    return names, [prefix + joint for joint in joints]


def add_pairs(spec, case, geoms, options, step):
    """Adds contact pairs of all geoms of the bodies that have friction with each other."""
    for friction in case.friction:
        for first, second in itertools.product(*(geoms[name] for name in friction.bodies)):
            pair = spec.add_pair(geomname1=first, geomname2=second)
            # Frictionless contacts have one dimension: MuJoCo raises smaller coefficients to 1e-5.
            pair.condim = 3 if friction.kinetic > 0.0 else 1
            pair.friction[:2] = friction.kinetic
            if options.solref_steps is not None:
                pair.solref = [options.solref_steps * step, 1.0]
            if options.friction_time is not None:
                pair.solreffriction = [options.friction_time * math.sqrt(step / 1e-3), 1.0]
            if options.impedance is not None:
                pair.solimp[:2] = options.impedance


class MujocoSimulation(Simulation):
    """A case in MuJoCo."""

    def __init__(self, case, options, step):
        unsupported(case)
        spec = mujoco.MjSpec()
        spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
        spec.compiler.fusestatic = False
        spec.option.gravity = case.gravity
        # A state that is no longer finite is a failure, not a new start.
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        options.apply(spec.option, step)
        # Sizes of 0 make the plane infinite.
        spec.worldbody.add_geom(
            name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=0
        )
        geoms, joints = {"floor": ["floor"]}, []
        for body in case.bodies:
            geoms[body.name], names = add_body(spec, body)
            joints.append(names)
        add_pairs(spec, case, geoms, options, step)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.step, self.steps = step, 0
        self.bodies = []
        for body, names in zip(case.bodies, joints):
            free = self.model.joint(f"{body.name}/free")
            indices = [self.model.joint(name) for name in names]
            self.bodies.append((
                free.qposadr[0], free.dofadr[0],
                numpy.array([joint.qposadr[0] for joint in indices], dtype=int),
                numpy.array([joint.dofadr[0] for joint in indices], dtype=int),
            ))
            self.start(body, free, names)
        self.forces = [(force, self.model.body(f"{force.body}/{force.link}").id) for force in case.forces]
        mujoco.mj_forward(self.model, self.data)

    def start(self, body, free, names):
        """Sets the initial state of a body and the targets of its servos."""
        position, velocity = self.data.qpos, self.data.qvel
        q, v = free.qposadr[0], free.dofadr[0]
        position[q : q + 3], position[q + 3 : q + 7] = body.position, body.orientation
        velocity[v : v + 3] = body.linear_velocity
        # Angular velocities of free joints are in the axes of the body.
        inverse = numpy.zeros(4)
        mujoco.mju_negQuat(inverse, body.orientation)
        mujoco.mju_rotVecQuat(velocity[v + 3 : v + 6], body.angular_velocity, inverse)
        for name in names:
            joint = self.model.joint(name)
            key = name.removeprefix(f"{body.name}/")
            position[joint.qposadr[0]] = body.joints.get(key, 0.0)
            velocity[joint.dofadr[0]] = body.joint_velocities.get(key, 0.0)
        for name, servo in body.servos.items():
            self.data.ctrl[self.model.actuator(f"{body.name}/{name}").id] = servo.target

    @property
    def time(self):
        return self.steps * self.step

    def quiet_steps(self):
        """Number of steps from now on at which no force acts; infinite after the last one."""
        least = math.inf
        for force, _ in self.forces:
            first, last = force.knots[0, 0], force.knots[-1, 0]
            if self.time <= last:
                # One step early at most: `Force.at` decides which forces are zero.
                least = min(least, max(0, math.floor((first - self.time) / self.step)))
        return least

    def advance(self, steps):
        model, data = self.model, self.data
        end = self.steps + steps
        while self.steps < end:
            quiet = min(self.quiet_steps(), end - self.steps)
            if quiet:
                data.xfrc_applied[:] = 0.0
                mujoco.mj_step(model, data, nstep=quiet)
                self.steps += quiet
                continue
            mujoco.mj_step1(model, data)  # positions of the links at the start of the step
            self.apply_forces()
            mujoco.mj_step2(model, data)
            self.steps += 1
        if any(data.warning[kind].number for kind in DIVERGED) or not numpy.isfinite(data.qvel).all():
            raise Failed(f"the state is not finite or too large at {self.time:g} s")

    def apply_forces(self):
        """Sets forces and moments on the centres of mass of the links, in world axes."""
        data = self.data
        data.xfrc_applied[:] = 0.0
        for force, link in self.forces:
            vector, moment = force.at(self.time)
            point = data.xpos[link] + data.xmat[link].reshape(3, 3) @ force.point
            data.xfrc_applied[link, :3] += vector
            data.xfrc_applied[link, 3:] += moment + numpy.cross(point - data.xipos[link], vector)

    def states(self):
        position, velocity = self.data.qpos, self.data.qvel
        states = []
        for q, v, q_joints, v_joints in self.bodies:
            orientation, angular = position[q + 3 : q + 7].copy(), numpy.zeros(3)
            mujoco.mju_rotVecQuat(angular, velocity[v + 3 : v + 6], orientation)
            states.append(BodyState(
                position=position[q : q + 3].copy(),
                orientation=orientation,
                linear_velocity=velocity[v : v + 3].copy(),
                angular_velocity=angular,
                q=position[q_joints],
                qd=velocity[v_joints],
            ))
        return states


class Adapter(Engine):
    """MuJoCo."""

    name = "mujoco"
    package = "mujoco"

    def version(self):
        return mujoco.__version__

    def settings(self):
        return SETTINGS

    def simulation(self, case, settings, step):
        return MujocoSimulation(case, OPTIONS[settings.name], step)
