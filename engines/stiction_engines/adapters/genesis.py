"""Runs cases in Genesis, whose rigid solver is a relative of MuJoCo's, on a CPU in double precision.

A case becomes a plane and a URDF morph per body, with the shapes that touch added. A contact has the larger
of two coefficients of friction; bit masks let only pairs of the case touch. Genesis compiles its kernels
when a process first needs them, and keeps them in a cache on disk.
"""

from dataclasses import dataclass, field
from importlib.metadata import version

import genesis
import numpy

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported
from stiction_engines.series import matrix
from stiction_engines.urdf import joint_names, with_shapes

# Radius of the sphere that stands for a point of contact, m. Its lowest point is the point where the link
# is level; where the link tilts by an angle a, it is lower by r (1 - cos a).
POINT_RADIUS = 1e-5
# Range of coefficients of friction that Genesis takes.
LEAST_FRICTION, MOST_FRICTION = 0.01, 5.0


@dataclass(frozen=True)
class Options:
    """Fields of `RigidOptions`; values of `names` are names of members of Genesis's enumerations."""

    values: dict = field(default_factory=dict)
    names: dict = field(default_factory=dict)

    def rigid(self):
        """Genesis's options. Its enumerations exist after `genesis.init` only."""
        named = {key: getattr(getattr(genesis, key), name) for key, name in self.names.items()}
        return genesis.options.RigidOptions(
            enable_self_collision=False, enable_joint_limit=False, **self.values, **named
        )


OPTIONS = {
    "default": Options(),
    "accurate": Options(
        {"constraint_timeconst": None, "iterations": 200, "tolerance": 1e-12},
        {"friction_cone": "elliptic", "integrator": "implicitfast"},
    ),
}

SETTINGS = [
    Settings("default", "Genesis's defaults: pyramidal cone, contacts with a time constant of 10 ms"),
    Settings("accurate", "elliptic cone, friction bounded by the developed normal force, stiffest contacts"),
]


def unsupported(case):
    """Raises `Unsupported` for what Genesis cannot express."""
    if case.has_two_coefficients:
        raise Unsupported("one coefficient of friction: static and kinetic friction cannot differ")
    if case.restitution != 0.0:
        raise Unsupported("no coefficient of restitution: contacts are damped springs")
    for friction in case.friction:
        if not LEAST_FRICTION <= friction.kinetic <= MOST_FRICTION:
            raise Unsupported(f"coefficients of friction from {LEAST_FRICTION:g} to {MOST_FRICTION:g}")


def coefficients(case):
    """Coefficients of the floor and the bodies. The larger one of a pair is that of the pair."""
    found = {}
    for name in {name for friction in case.friction for name in friction.bodies}:
        found[name] = min(friction.kinetic for friction in case.friction if name in friction.bodies)
    for friction in case.friction:
        if max(found[name] for name in friction.bodies) != friction.kinetic:
            raise Unsupported("friction is the larger of two coefficients: the pairs of the case are not")
    return found


def masks(case):
    """Bit masks that let the pairs of the case touch, by body: bit k is that of pair k."""
    names = ["floor", *(body.name for body in case.bodies)]
    found = {name: {"contype": 0, "conaffinity": 0} for name in names}
    for k, friction in enumerate(case.friction):
        first, second = friction.bodies
        found[first]["contype"] |= 1 << k
        found[second]["conaffinity"] |= 1 << k
    return found


class Entity:
    """A body of a case in a scene."""

    def __init__(self, body, scene, friction, mask):
        self.body = body
        urdf, self.names = with_shapes(body, POINT_RADIUS), joint_names(body)
        self.entity = scene.add_entity(
            genesis.morphs.URDF(
                file=urdf, merge_fixed_links=False, default_armature=None, align=False,
                collision=bool(body.touching),
            ),
            material=genesis.materials.Rigid(friction=friction),
        )
        # Morphs of URDFs have no bit masks; the collider reads them from here when the scene is built.
        for geom in self.entity.geoms:
            geom.desc.contype, geom.desc.conaffinity = mask["contype"], mask["conaffinity"]

    def start(self):
        """Sets the initial state, rotors and servos of the built entity."""
        body, entity = self.body, self.entity
        joints = [entity.get_joint(name) for name in self.names]
        self.q = [joint.qs_idx_local[0] for joint in joints]
        self.dofs = [joint.dofs_idx_local[0] for joint in joints]
        q, velocity = numpy.zeros(entity.n_qs), numpy.zeros(entity.n_dofs)
        q[:3], q[3:7] = body.position, body.orientation
        # Angular velocities of free joints are in the axes of the body.
        velocity[:3] = body.linear_velocity
        velocity[3:6] = matrix(body.orientation).T @ body.angular_velocity
        q[self.q] = [body.joints.get(name, 0.0) for name in self.names]
        velocity[self.dofs] = [body.joint_velocities.get(name, 0.0) for name in self.names]
        for clear in (entity.set_dofs_damping, entity.set_dofs_frictionloss, entity.set_dofs_stiffness):
            clear(numpy.zeros(entity.n_dofs))
        entity.set_qpos(q)
        entity.set_dofs_velocity(velocity)
        if self.dofs:
            entity.set_dofs_armature([body.armature.get(name, 0.0) for name in self.names], self.dofs)
        driven = [(dof, body.servos[name]) for name, dof in zip(self.names, self.dofs) if name in body.servos]
        if driven:
            dofs, servos = zip(*driven)
            entity.set_dofs_kp([servo.kp for servo in servos], dofs)
            entity.set_dofs_kv([servo.kd for servo in servos], dofs)
            entity.set_dofs_force_range([-1e9] * len(dofs), [1e9] * len(dofs), dofs)
            entity.control_dofs_position([servo.target for servo in servos], dofs)

    def apply_force(self, link, point, force, moment):
        """Adds a force at a point of a link and a moment, both in world axes, to the next step."""
        link = self.entity.get_link(link)
        position, orientation = link.get_pos().numpy(), link.get_quat().numpy()
        self.entity.apply_links_external_wrench(
            force, moment, [link.idx_local], pos=position + matrix(orientation) @ point
        )

    def state(self):
        """`BodyState` of the body."""
        entity = self.entity
        array = lambda values: numpy.array(values, dtype=float)
        return BodyState(
            position=array(entity.get_pos()),
            orientation=array(entity.get_quat()),
            linear_velocity=array(entity.get_vel()),
            angular_velocity=array(entity.get_ang()),
            q=array(entity.get_qpos())[self.q],
            qd=array(entity.get_dofs_velocity())[self.dofs],
        )


class GenesisSimulation(Simulation):
    """A case in a scene of its own."""

    def __init__(self, case, options, step):
        unsupported(case)
        frictions, mask = coefficients(case), masks(case)
        self.step, self.steps = step, 0
        self.scene = genesis.Scene(
            sim_options=genesis.options.SimOptions(dt=step, gravity=tuple(case.gravity)),
            rigid_options=options.rigid(), show_viewer=False,
        )
        if "floor" in frictions:
            self.scene.add_entity(
                genesis.morphs.Plane(**mask["floor"]),
                material=genesis.materials.Rigid(friction=frictions["floor"]),
            )
        self.bodies = [
            Entity(body, self.scene, frictions.get(body.name, 1.0), mask[body.name]) for body in case.bodies
        ]
        self.scene.build()
        for entity in self.bodies:
            entity.start()
        named = {body.name: entity for body, entity in zip(case.bodies, self.bodies)}
        self.forces = [(force, named[force.body]) for force in case.forces]

    def __del__(self):
        # At exit, Genesis has destroyed its scenes before.
        if hasattr(self, "scene") and genesis is not None and genesis._initialized:
            self.scene.destroy()

    @property
    def time(self):
        return self.steps * self.step

    def advance(self, steps):
        try:
            for _ in range(steps):
                for force, entity in self.forces:
                    if force.knots[0, 0] <= self.time <= force.knots[-1, 0]:
                        entity.apply_force(force.link, force.point, *force.at(self.time))
                self.scene.step()
                self.steps += 1
        except genesis.GenesisException as error:
            raise Failed(str(error).splitlines()[0]) from error

    def states(self):
        return [entity.state() for entity in self.bodies]


class Adapter(Engine):
    """Genesis."""

    name = "genesis"
    package = "genesis-world"

    def version(self):
        return version("genesis-world")

    def settings(self):
        return SETTINGS

    def simulation(self, case, settings, step):
        if not getattr(genesis, "_initialized", False):
            genesis.init(backend=genesis.cpu, precision="64", logging_level="error")
        return GenesisSimulation(case, OPTIONS[settings.name], step)
