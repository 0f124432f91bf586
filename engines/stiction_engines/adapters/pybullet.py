"""Runs cases in PyBullet.

A case becomes Bullet multibodies and a plane. The multibodies are read from copies of the URDF files, with
the shapes that touch added. Only the pairs of the case pass the collision filter. Damping of velocities,
0.04 per second by default, is 0 in all settings: it is a drag, which the cases do not have.
"""

import itertools
import math
import tempfile
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import numpy
import pybullet

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported
from stiction_engines.urdf import joint_names, with_shapes

# Radius of the sphere that stands for a point of contact, m. Its lowest point is the point where the link
# is level; where the link tilts by an angle a, it is lower by r (1 - cos a).
POINT_RADIUS = 1e-6
# Bullet clamps combined coefficients of friction to this.
MOST_FRICTION = 10.0
# Index of the root link.
BASE = -1


@dataclass(frozen=True)
class Options:
    """Arguments of `setPhysicsEngineParameter`; where contacts bounce, more of them and of `changeDynamics`.

    All settings have `contactBreakingThreshold`: Bullet keeps one value for all clients of a process.
    """

    engine: dict
    bouncing_engine: dict = field(default_factory=dict)
    bouncing_dynamics: dict = field(default_factory=dict)


# Choices of "accurate", measured on the cases of this package:
# - Iterations end by the residual: 200 give the same, but stacks may need more.
# - contactBreakingThreshold, relative to the size of a shape: contacts are found before bodies touch. At 4
#   ms a box that slides stops 0.5 ms late with 0.3, 160 ms late with the default, 0.02.
# - contactSlop: by default bodies rest 10 um inside of each other.
# - contactERP, frictionERP, globalCFM and the margin stay: others change no figure or worsen it. A
#   contactERP of 0.2 lets a box that falls rebound by 3 cm at 4 ms.
# - Cone friction is Bullet's default. useSplitImpulse has no effect on multibodies.
# - Bouncing: contacts that are found early stop a body before it touches, and it does not rebound at all at
#   1 ms. With contactProcessingThreshold 0 only bodies that touch are stopped; ERP then adds speed to the
#   rebound, hence 0.01.
OPTIONS = {
    "default": Options({"contactBreakingThreshold": 0.02}),
    "accurate": Options(
        {
            "numSolverIterations": 1000, "solverResidualThreshold": 1e-16,
            "contactBreakingThreshold": 0.3, "contactSlop": 0.0,
        },
        bouncing_engine={"contactERP": 0.01},
        bouncing_dynamics={"contactProcessingThreshold": 0.0},
    ),
}

SETTINGS = [
    Settings("default", "PyBullet's defaults without damping: sequential impulses, 50 iterations"),
    Settings("accurate", "1000 iterations to a residual of 1e-16, contacts found early, no slop"),
]


def unsupported(case):
    """Raises `Unsupported` for what PyBullet cannot express."""
    if case.has_two_coefficients:
        raise Unsupported("one coefficient of friction: static and kinetic friction cannot differ")
    if any(value != 0.0 for body in case.bodies for value in body.armature.values()):
        raise Unsupported("no inertia of rotors: joints have no armature")


def shares_of_friction(case):
    """Coefficients of the floor and the bodies whose products are those of the pairs."""
    pairs = [(friction.bodies, friction.kinetic) for friction in case.friction]
    rough = sorted({name for names, mu in pairs if mu > 0.0 for name in names})
    for names, mu in pairs:
        if mu > MOST_FRICTION:
            raise Unsupported(f"coefficients of friction of at most {MOST_FRICTION:g}")
        if mu == 0.0 and set(names) <= set(rough):
            raise Unsupported("friction is a product of two coefficients: not zero for one pair alone")
    # Logarithms of the coefficients add up.
    positive = [(names, mu) for names, mu in pairs if mu > 0.0]
    matrix = numpy.zeros((len(positive), len(rough)))
    for row, (names, _) in enumerate(positive):
        for name in names:
            matrix[row, rough.index(name)] += 1.0
    logarithms = numpy.log([mu for _, mu in positive])
    shares = numpy.linalg.lstsq(matrix, logarithms, rcond=None)[0]
    if positive and numpy.abs(matrix @ shares - logarithms).max() > 1e-12:
        raise Unsupported("friction is a product of two coefficients: the pairs of the case are not")
    return dict(zip(rough, numpy.exp(shares)))


def xyzw(quaternion):
    """Bullet's order of a quaternion."""
    return [*quaternion[1:], quaternion[0]]


def rotation(quaternion):
    """Matrix of a quaternion in Bullet's order. PyBullet's own functions of poses have single precision."""
    x, y, z, w = quaternion
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def product(first, second):
    """Product of two quaternions in Bullet's order."""
    a, b = numpy.array(first[:3]), numpy.array(second[:3])
    vector = first[3] * b + second[3] * a + numpy.cross(a, b)
    return numpy.array([*vector, first[3] * second[3] - a @ b])


class Multibody:
    """A body of a case in a client of Bullet.

    Bullet shrinks boxes and cylinders by a margin and adds it around them: faces keep their place; where GJK
    finds the contact, edges are rounded with this radius. The margin stays at the 1 mm of PyBullet.
    """

    def __init__(self, body, client, folder):
        self.client = {"physicsClientId": client}
        urdf, names = with_shapes(body, POINT_RADIUS), joint_names(body)
        file = Path(folder) / f"{body.name}.urdf"
        file.write_text(urdf)
        self.id = pybullet.loadURDF(
            str(file), **self.client,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER,
        )
        count = pybullet.getNumJoints(self.id, **self.client)
        infos = [pybullet.getJointInfo(self.id, index, **self.client) for index in range(count)]
        # The link of a joint has the joint's index.
        self.links = {info[12].decode(): index for index, info in enumerate(infos)}
        base, _ = pybullet.getBodyInfo(self.id, **self.client)
        self.links[base.decode()] = BASE
        indices = {info[1].decode(): index for index, info in enumerate(infos)}
        self.joints = [indices[name] for name in names]
        # Bullet's frames are the inertial ones. Their poses in the frames of the links:
        self.inertial = {}
        for link in self.links.values():
            dynamics = pybullet.getDynamicsInfo(self.id, link, **self.client)
            self.inertial[link] = numpy.array(dynamics[3]), numpy.array(dynamics[4])
        self.touching = [self.links[link] for link in body.touching]
        self.start(body, names)
        servos = [(indices[name], servo) for name, servo in body.servos.items()]
        self.servo_joints = [index for index, _ in servos]
        self.gains = numpy.array([[servo.kp, servo.kd, servo.target] for _, servo in servos]).T

    def start(self, body, names):
        """Sets the initial state and releases the motors that Bullet adds to joints."""
        orientation = xyzw(body.orientation)
        centre, axes = self.inertial[BASE]
        arm = rotation(orientation) @ centre
        pybullet.resetBasePositionAndOrientation(
            self.id, body.position + arm, product(orientation, axes), **self.client
        )
        velocity = body.linear_velocity + numpy.cross(body.angular_velocity, arm)
        pybullet.resetBaseVelocity(self.id, velocity, body.angular_velocity, **self.client)
        for index, name in zip(self.joints, names):
            q, qd = body.joints.get(name, 0.0), body.joint_velocities.get(name, 0.0)
            pybullet.resetJointState(self.id, index, q, qd, **self.client)
        if self.joints:
            pybullet.setJointMotorControlArray(
                self.id, self.joints, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(self.joints),
                **self.client,
            )

    def set_dynamics(self, **values):
        """Sets dynamics of all links."""
        for link in self.links.values():
            pybullet.changeDynamics(self.id, link, **self.client, **values)

    def apply_servos(self):
        """Sets the efforts of the servos for the next step."""
        if not self.servo_joints:
            return
        joints = pybullet.getJointStates(self.id, self.servo_joints, **self.client)
        kp, kd, target = self.gains
        efforts = kp * (target - [joint[0] for joint in joints]) - kd * [joint[1] for joint in joints]
        pybullet.setJointMotorControlArray(
            self.id, self.servo_joints, pybullet.TORQUE_CONTROL, forces=efforts, **self.client
        )

    def frame(self, link):
        """Position and orientation, in Bullet's order, of a link's frame."""
        if link == BASE:
            position, orientation = pybullet.getBasePositionAndOrientation(self.id, **self.client)
        else:
            state = pybullet.getLinkState(self.id, link, computeForwardKinematics=1, **self.client)
            position, orientation = state[:2]
        centre, axes = self.inertial[link]
        orientation = product(orientation, axes * [-1, -1, -1, 1])
        return position - rotation(orientation) @ centre, orientation

    def apply_force(self, link, point, force, moment):
        """Adds a force at a point of a link and a moment, both in world axes, to the next step."""
        position, orientation = self.frame(link)
        point = position + rotation(orientation) @ point
        world = {"flags": pybullet.WORLD_FRAME, **self.client}
        pybullet.applyExternalForce(self.id, link, force, point, **world)
        if moment.any():
            pybullet.applyExternalTorque(self.id, link, moment, **world)

    def joint_states(self):
        """PyBullet's states of the joints, in the order of the URDF."""
        return pybullet.getJointStates(self.id, self.joints, **self.client) if self.joints else []

    def is_finite(self):
        """False if a velocity is not a number or infinite: positions follow."""
        linear, angular = pybullet.getBaseVelocity(self.id, **self.client)
        joints = self.joint_states()
        return all(map(math.isfinite, (*linear, *angular, *(joint[1] for joint in joints))))

    def state(self):
        """`BodyState` of the body."""
        position, orientation = self.frame(BASE)
        linear, angular = map(numpy.array, pybullet.getBaseVelocity(self.id, **self.client))
        arm = rotation(orientation) @ self.inertial[BASE][0]
        joints = self.joint_states()
        return BodyState(
            position=numpy.array(position),
            orientation=numpy.array([orientation[3], *orientation[:3]]),
            linear_velocity=linear - numpy.cross(angular, arm),
            angular_velocity=angular,
            q=numpy.array([joint[0] for joint in joints]),
            qd=numpy.array([joint[1] for joint in joints]),
        )


class PybulletSimulation(Simulation):
    """A case in a client of Bullet of its own."""

    def __init__(self, case, options, step):
        unsupported(case)
        shares = shares_of_friction(case)
        self.step, self.steps = step, 0
        self.client = pybullet.connect(pybullet.DIRECT)
        client = {"physicsClientId": self.client}
        pybullet.setGravity(*case.gravity, **client)
        bounces = case.restitution != 0.0
        engine = options.engine | (options.bouncing_engine if bounces else {})
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step, numSubSteps=0, deterministicOverlappingPairs=1, **engine, **client
        )
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=[0, 0, 1], **client)
        floor = pybullet.createMultiBody(0.0, plane, **client)
        with tempfile.TemporaryDirectory() as folder:
            self.bodies = [Multibody(body, self.client, folder) for body in case.bodies]
        names = {body.name: bullet for body, bullet in zip(case.bodies, self.bodies)}
        # Restitution is a product of two coefficients, too.
        surface = {
            "rollingFriction": 0.0, "spinningFriction": 0.0, "restitution": math.sqrt(case.restitution),
            **(options.bouncing_dynamics if bounces else {}),
        }
        pybullet.changeDynamics(floor, BASE, lateralFriction=shares.get("floor", 0.0), **surface, **client)
        for name, bullet in names.items():
            bullet.set_dynamics(
                lateralFriction=shares.get(name, 0.0),
                linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, **surface,
            )
        self.filter(case, names, floor)
        pushed = [(force, names[force.body]) for force in case.forces]
        self.forces = [(force, bullet, bullet.links[force.link]) for force, bullet in pushed]
        self.driven = [bullet for bullet in self.bodies if bullet.servo_joints]

    def filter(self, case, names, floor):
        """Lets only pairs of the case touch."""
        client = {"physicsClientId": self.client}
        links = {"floor": [(floor, BASE)]}
        for name, bullet in names.items():
            links[name] = [(bullet.id, link) for link in bullet.touching]
        for body, link in itertools.chain.from_iterable(links.values()):
            pybullet.setCollisionFilterGroupMask(body, link, 0, 0, **client)
        for friction in case.friction:
            for first, second in itertools.product(*(links[name] for name in friction.bodies)):
                pybullet.setCollisionFilterPair(first[0], second[0], first[1], second[1], 1, **client)

    def __del__(self):
        if hasattr(self, "client"):
            pybullet.disconnect(self.client)

    @property
    def time(self):
        return self.steps * self.step

    def advance(self, steps):
        for _ in range(steps):
            for bullet in self.driven:
                bullet.apply_servos()
            for force, bullet, link in self.forces:
                if force.knots[0, 0] <= self.time <= force.knots[-1, 0]:
                    bullet.apply_force(link, force.point, *force.at(self.time))
            pybullet.stepSimulation(physicsClientId=self.client)
            self.steps += 1
        if not all(bullet.is_finite() for bullet in self.bodies):
            raise Failed(f"the state is not finite at {self.time:g} s")

    def states(self):
        return [bullet.state() for bullet in self.bodies]


class Adapter(Engine):
    """PyBullet."""

    name = "pybullet"
    package = "pybullet"

    def version(self):
        return version("pybullet")

    def settings(self):
        return SETTINGS

    def simulation(self, case, settings, step):
        return PybulletSimulation(case, OPTIONS[settings.name], step)
