"""Runs cases with the solvers of Newton on a CPU: XPBD, Kamino, Steel and Featherstone.

Newton's arrays have single precision. Every pair of bodies that touches has its own copies of their shapes,
which carry the friction and restitution of the pair: all solvers take the mean of two coefficients, which
is either one where they are equal. Kamino takes the smaller restitution, which is the same. The collision
pipeline gets the list of the pairs, so nothing else touches. SolverMuJoCo is left out: it is MuJoCo, which
has an adapter.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy
import warp

# Warp reports each kernel that it loads; set before Newton loads any.
warp.config.log_level = warp.LOG_ERROR

import newton  # noqa: E402

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported  # noqa: E402
from stiction_engines.series import matrix  # noqa: E402
from stiction_engines.urdf import joint_names  # noqa: E402

# Radius of the sphere that stands for a point of contact, m. Its lowest point is the point where the link
# is level; where the link tilts by an angle a, it is lower by r (1 - cos a).
POINT_RADIUS = 1e-5


@dataclass(frozen=True)
class Options:
    """A solver, how it is made, and what it cannot express.

    `shape` holds fields of `ShapeConfig`. `maximal`: the solver's state is the poses of all links, not the
    joints.
    `lacks` names what raises `Unsupported`.
    """

    solver: Callable
    arguments: dict = field(default_factory=dict)
    shape: dict = field(default_factory=dict)
    maximal: bool = False
    lacks: tuple[str, ...] = ()


REASONS = {
    "restitution": "no coefficient of restitution: contacts are damped springs",
    "armature": "no inertia of rotors: the solver ignores the armature of joints",
}


def kamino(model):
    """A Kamino solver with its default configuration."""
    return newton.solvers.SolverKamino(model, config=newton.solvers.SolverKamino.Config())


def steel(model, **arguments):
    """A Steel solver without the damping of angular velocities, 0.05 per second, that it has by default."""
    model.steel.rigid_body_angular_damping.zero_()
    return newton.solvers.SolverSteel(model, **arguments)


# Choices of "accurate", measured on the cases of this package at a step of 1 ms:
# - XPBD: with the default, 2 iterations, a box creeps down a slope by 8 mm/s, with 20 by 0.2 mm/s.
# - Steel: with the default, 12 iterations, a stack of five boxes sinks by 48 um, with 100 by 4 um. Point
#   friction, without friction patches (friction_anchor_beta 0), lets a box creep down a slope by 0.03 mm/s;
#   with patches it does not creep.
OPTIONS = {
    "xpbd": Options(
        newton.solvers.SolverXPBD, {"enable_restitution": True}, maximal=True, lacks=("armature",)
    ),
    "xpbd-accurate": Options(
        newton.solvers.SolverXPBD, {"enable_restitution": True, "iterations": 20},
        maximal=True, lacks=("armature",),
    ),
    "kamino": Options(kamino, maximal=True),
    "steel": Options(steel),
    "steel-accurate": Options(steel, {"iterations": 100}),
    "featherstone": Options(
        newton.solvers.SolverFeatherstone, {"angular_damping": 0.0}, lacks=("restitution",)
    ),
}

SETTINGS = [
    Settings("xpbd", "SolverXPBD's defaults with restitution: 2 iterations on positions"),
    Settings("xpbd-accurate", "SolverXPBD with 20 iterations"),
    Settings("kamino", "SolverKamino's defaults: proximal ADMM to 1e-6, at most 200 iterations"),
    Settings("steel", "SolverSteel's defaults without damping: projected Gauss-Seidel, 12 iterations"),
    Settings("steel-accurate", "SolverSteel without damping: projected Gauss-Seidel, 100 iterations"),
    Settings("featherstone", "SolverFeatherstone without damping: contacts are springs of 2500 N/m"),
]


def unsupported(case, options):
    """Raises `Unsupported` for what Newton, or one of its solvers, cannot express."""
    if case.has_two_coefficients:
        raise Unsupported("one coefficient of friction: static and kinetic friction cannot differ")
    if "restitution" in options.lacks and case.restitution != 0.0:
        raise Unsupported(REASONS["restitution"])
    if "armature" in options.lacks and any(any(body.armature.values()) for body in case.bodies):
        raise Unsupported(REASONS["armature"])


def xyzw(quaternion):
    """Warp's order of a quaternion."""
    return [*quaternion[1:], quaternion[0]]


def add_shapes(builder, link, shape, config):
    """Adds a shape to a link and returns its indices."""
    place = warp.transform(shape.position, xyzw(shape.orientation))
    if shape.kind == "box":
        hx, hy, hz = shape.size / 2
        return [builder.add_shape_box(link, xform=place, hx=hx, hy=hy, hz=hz, cfg=config)]
    if shape.kind == "sphere":
        return [builder.add_shape_sphere(link, xform=place, radius=shape.radius, cfg=config)]
    if shape.kind == "cylinder":
        return [
            builder.add_shape_cylinder(
                link, xform=place, radius=shape.radius, half_height=shape.length / 2, cfg=config
            )
        ]
    if shape.kind == "points":
        centres = shape.position + shape.points @ matrix(shape.orientation).T + [0.0, 0.0, POINT_RADIUS]
        return [
            builder.add_shape_sphere(
                link, xform=warp.transform(centre, warp.quat_identity()), radius=POINT_RADIUS, cfg=config
            )
            for centre in centres
        ]
    raise Unsupported(f"no shape {shape.kind!r}")


class Articulation:
    """A body of a case in a builder: indices of its links and joints, its drives and its initial state."""

    def __init__(self, body, builder):
        first_link, first_joint = len(builder.body_label), len(builder.joint_label)
        builder.add_urdf(str(body.urdf), floating=True, enable_self_collisions=False)
        name = lambda label: label.rsplit("/", 1)[-1]
        self.body = body
        self.links = {name(label): first_link + k for k, label in enumerate(builder.body_label[first_link:])}
        joints = {name(label): first_joint + k for k, label in enumerate(builder.joint_label[first_joint:])}
        self.names = joint_names(body)
        self.root = builder.joint_child[first_joint]
        self.centre = numpy.array(builder.body_com[self.root])
        self.q, self.qd = builder.joint_q_start[first_joint], builder.joint_qd_start[first_joint]
        self.joints_q = [builder.joint_q_start[joints[name]] for name in self.names]
        self.joints_qd = [builder.joint_qd_start[joints[name]] for name in self.names]
        for joint, q, dof in zip(self.names, self.joints_q, self.joints_qd):
            builder.joint_armature[dof] = body.armature.get(joint, 0.0)
            builder.joint_damping[dof] = builder.joint_friction[dof] = 0.0
            builder.joint_effort_limit[dof] = builder.joint_velocity_limit[dof] = 1e9
            builder.joint_target_mode[dof] = int(newton.JointTargetMode.NONE)
            if joint in body.servos:
                servo = body.servos[joint]
                builder.joint_target_mode[dof] = int(newton.JointTargetMode.POSITION_VELOCITY)
                builder.joint_target_ke[dof], builder.joint_target_kd[dof] = servo.kp, servo.kd
                builder.joint_target_q[q] = servo.target

    def start(self, q, qd):
        """Writes the initial state into joint coordinates: free joints have the centre of mass's velocity."""
        body = self.body
        q[self.q : self.q + 7] = [*body.position, *xyzw(body.orientation)]
        arm = matrix(body.orientation) @ self.centre
        qd[self.qd : self.qd + 3] = body.linear_velocity + numpy.cross(body.angular_velocity, arm)
        qd[self.qd + 3 : self.qd + 6] = body.angular_velocity
        q[self.joints_q] = [body.joints.get(name, 0.0) for name in self.names]
        qd[self.joints_qd] = [body.joint_velocities.get(name, 0.0) for name in self.names]

    def state(self, poses, velocities, q, qd):
        """`BodyState` of arrays of the links and the joints."""
        pose = poses[self.root].astype(float)
        velocity, angular = velocities[self.root, :3].astype(float), velocities[self.root, 3:].astype(float)
        orientation = numpy.array([pose[6], *pose[3:6]])
        orientation /= numpy.linalg.norm(orientation)
        return BodyState(
            position=pose[:3],
            orientation=orientation,
            linear_velocity=velocity - numpy.cross(angular, matrix(orientation) @ self.centre),
            angular_velocity=angular,
            q=q[self.joints_q].astype(float),
            qd=qd[self.joints_qd].astype(float),
        )


def add_pairs(builder, case, bodies, options):
    """Adds shapes for all pairs of the case. Returns the pairs of shapes that may touch."""
    pairs = []
    for friction in case.friction:
        config = newton.ModelBuilder.ShapeConfig(
            density=0.0, mu=friction.kinetic, mu_torsional=0.0, mu_rolling=0.0,
            restitution=case.restitution, **options.shape,
        )
        sides = []
        for name in friction.bodies:
            if name == "floor":
                sides.append([builder.add_ground_plane(cfg=config)])
                continue
            shapes = [(bodies[name].links[link], shape) for link, shapes in case.body(name).touching.items()
                      for shape in shapes]
            sides.append([
                index for link, shape in shapes for index in add_shapes(builder, link, shape, config)
            ])
        pairs += [(min(pair), max(pair)) for pair in itertools.product(*sides)]
    return sorted(pairs)


class NewtonSimulation(Simulation):
    """A case in a model of Newton."""

    def __init__(self, case, options, step):
        unsupported(case, options)
        self.step, self.steps, self.maximal = step, 0, options.maximal
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=tuple(case.gravity))
        newton.solvers.SolverSteel.register_custom_attributes(builder)
        self.bodies = [Articulation(body, builder) for body in case.bodies]
        named = {body.name: articulation for body, articulation in zip(case.bodies, self.bodies)}
        pairs = add_pairs(builder, case, named, options)
        builder.color()
        self.model = builder.finalize(device="cpu")
        self.model.rigid_contact_max = 16 * len(pairs)
        q, qd = self.model.joint_q.numpy(), self.model.joint_qd.numpy()
        for articulation in self.bodies:
            articulation.start(q, qd)
        self.model.joint_q.assign(q)
        self.model.joint_qd.assign(qd)
        newton.eval_fk(self.model, self.model.joint_q, self.model.joint_qd, self.model)
        self.now, self.next = self.model.state(), self.model.state()
        self.control = self.model.control()
        self.pipeline = self.contacts = None
        if pairs:
            self.pipeline = newton.CollisionPipeline(
                self.model, broad_phase="explicit", rigid_contact_max=16 * len(pairs),
                shape_pairs_filtered=warp.array(pairs, dtype=warp.vec2i, device="cpu"),
            )
            self.contacts = self.pipeline.contacts()
        self.solver = options.solver(self.model, **options.arguments)
        self.centres = self.model.body_com.numpy().astype(float)
        self.forces = [(force, named[force.body].links[force.link]) for force in case.forces]

    @property
    def time(self):
        return self.steps * self.step

    def apply_forces(self):
        """Sets forces and moments on the centres of mass of the links, in world axes."""
        self.now.clear_forces()
        active = [
            (force, link) for force, link in self.forces
            if force.knots[0, 0] <= self.time <= force.knots[-1, 0]
        ]
        if not active:
            return
        wrenches, poses = self.now.body_f.numpy(), self.now.body_q.numpy()
        for force, link in active:
            vector, moment = force.at(self.time)
            x, y, z, w = poses[link, 3:].astype(float)
            arm = matrix(numpy.array([w, x, y, z])) @ (force.point - self.centres[link])
            wrenches[link, :3] += vector
            wrenches[link, 3:] += moment + numpy.cross(arm, vector)
        self.now.body_f.assign(wrenches)

    def advance(self, steps):
        for _ in range(steps):
            self.apply_forces()
            if self.pipeline is not None:
                self.pipeline.collide(self.now, self.contacts)
            self.solver.step(self.now, self.next, self.control, self.contacts, self.step)
            self.now, self.next = self.next, self.now
            self.steps += 1
        if not numpy.isfinite(self.now.body_qd.numpy()).all():
            raise Failed(f"the state is not finite at {self.time:g} s")

    def states(self):
        state = self.now
        if self.maximal and any(articulation.names for articulation in self.bodies):
            newton.eval_ik(self.model, state, state.joint_q, state.joint_qd)
        arrays = [a.numpy() for a in (state.body_q, state.body_qd, state.joint_q, state.joint_qd)]
        return [articulation.state(*arrays) for articulation in self.bodies]


class Adapter(Engine):
    """Newton."""

    name = "newton"
    package = "newton"

    def version(self):
        return newton.__version__

    def settings(self):
        return SETTINGS

    def simulation(self, case, settings, step):
        return NewtonSimulation(case, OPTIONS[settings.name], step)
