"""Runs cases with Drake: its discrete contact solvers and its error-controlled integrator CENIC.

Drake's contact is compliant: a normal force of stiffness and dissipation, and Coulomb friction that is
regularized below a slip speed. Every pair of bodies that touches has its own copies of their shapes, which
carry the friction of the pair: Drake combines coefficients by 2 a b / (a + b), which is `a` for equal ones.
"""

import itertools
import logging
import math
from dataclasses import dataclass
from importlib.metadata import version

import numpy
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    CollisionFilterDeclaration,
    Cylinder,
    Ellipsoid,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import AffineSystem

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported
from stiction_engines.urdf import joint_names

# Drake warns of every rigid half space that it does not touch deformable bodies; no case has any.
logging.getLogger("drake").setLevel(logging.ERROR)

#: Radius of the spheres that stand for single points of contact, m. Where a link tilts by an angle a, the
#: point is off by r (1 - cos a).
POINT_RADIUS = 1e-6
#: Radius of the spheres at the corners of a box, m. It must exceed half the penetration, so that a corner on
#: the edge of another box finds the normal of its face.
CORNER_RADIUS = 1e-5
#: Length of the edges of hydroelastic meshes of cylinders, m: Drake's default. Boxes do not depend on it.
RESOLUTION = 0.02
#: Times that an adaptive engine reports, s.
REPORT = 1e-3


@dataclass(frozen=True)
class Options:
    """Options of Drake. None leaves a value to Drake.

    `hydroelastic`: boxes and cylinders are compliant volumes of `modulus` (Pa) on a rigid floor; otherwise
    boxes are spheres at their corners and cylinders discs at their ends. Balls and points are always in point
    contact. `stiffness` (N/m) is that of a pair in point contact. `stiction` is the slip speed (m/s) below
    which friction is regularized.
    """

    hydroelastic: bool = False
    modulus: float = 1e7
    stiffness: float | None = None
    stiction: float | None = None
    cenic: bool = False


# Measured at 1 ms with a box of 1 kg that slides to rest from 2 m/s, or rests for 1 s on a slope of 0.9 mu:
# - "default" slides 1.0 mm too far, creeps 0.23 mm and sinks 1.2 um.
# - "accurate" slides 1.0 mm too far, creeps 0.04 mm and sinks 0.12 um. The distance is one step without
#   friction: a box that starts without penetration has no contact in its first step. With spheres at its
#   corners it stops 11 mm early at 1e6 N/m and 350 mm early at 1e7 N/m, and feet beyond
#   1e6 N/m land worse at 4 ms.
# - "cenic" slides 0.12 mm short, creeps 0.03 mm and sinks 4.9 um. With two coefficients it breaks away 1 %
#   early; with stiction at 1e-6 m/s, 3.5 % early.
# Not offered: "similar" and "sap" let a box at 6 m/s hop 0.29 m; "tamsi" is deprecated and ignores servos.
OPTIONS = {
    "default": Options(hydroelastic=True),
    "accurate": Options(hydroelastic=True, modulus=1e8, stiffness=1e6, stiction=1e-5),
    "cenic": Options(stiction=1e-5, cenic=True),
}


class Adapter(Engine):
    """Drake."""

    name = "drake"
    package = "drake"

    def version(self):
        return version("drake")

    def settings(self):
        return [
            Settings(
                "default",
                "discrete plant, lagged approximation, default properties of contact, stiction at 0.1 mm/s; "
                "boxes and cylinders are hydroelastic of 1e7 Pa on a rigid floor, feet and balls points",
            ),
            Settings(
                "accurate",
                "as default, with 1e8 Pa for boxes and cylinders, 1e6 N/m for points, stiction at 0.01 mm/s",
            ),
            Settings(
                "cenic",
                "continuous plant, error-controlled integrator CENIC, default properties of contact, "
                "stiction at 0.01 mm/s; boxes are spheres at their corners, cylinders discs at their ends",
                steps=(1e-3, 1e-5, 1e-7),
                adaptive=True,
            ),
        ]

    def simulation(self, case, settings, step):
        return _Simulation(case, OPTIONS[settings.name], step)


class _Forces(LeafSystem):
    """Forces of a case on its links, as the plant's port of applied spatial forces takes them."""

    def __init__(self, forces, links):
        super().__init__()
        self._forces = list(zip(forces, links))
        allocate = Value[list[ExternallyAppliedSpatialForce]]
        self.DeclareAbstractOutputPort("forces", allocate, self._evaluate, {self.time_ticket()})

    def _evaluate(self, context, output):
        time = context.get_time()
        values = []
        for force, link in self._forces:
            f, moment = force.at(time)
            if f.any() or moment.any():
                applied = ExternallyAppliedSpatialForce()
                applied.body_index = link
                applied.p_BoBq_B = force.point
                applied.F_Bq_W = SpatialForce(tau=moment, f=f)
                values.append(applied)
        output.set_value(values)


class _Simulation(Simulation):
    def __init__(self, case, options, step):
        if case.restitution != 0:
            raise Unsupported("its compliant contact has no coefficient of restitution")
        if case.has_two_coefficients and not options.cenic:
            raise Unsupported("the discrete solvers use one coefficient of friction")
        self._case = case
        self._options = options
        self._step = REPORT if options.cenic else step
        self._steps = 0
        self._build(step)
        self._start()

    def _build(self, step):
        options = self._options
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=0.0 if options.cenic else step)
        if options.stiction:
            config.stiction_tolerance = options.stiction
        self._plant, self._scene = AddMultibodyPlant(config, builder)
        plant = self._plant
        plant.set_name("plant")
        plant.mutable_gravity_field().set_gravity_vector(self._case.gravity)
        self._models = [self._add_body(body) for body in self._case.bodies]
        self._add_contacts()
        plant.Finalize()
        if options.cenic:
            for body, model in zip(self._case.bodies, self._models):
                self._connect_servos(builder, body, model)
        if self._case.forces:
            links = [self._link(force.body, force.link).index() for force in self._case.forces]
            forces = builder.AddSystem(_Forces(self._case.forces, links))
            builder.Connect(forces.get_output_port(), plant.get_applied_spatial_force_input_port())
        self._diagram = builder.Build()
        self._simulator = Simulator(self._diagram)
        if options.cenic:
            ApplySimulatorConfig(SimulatorConfig(integration_scheme="cenic", accuracy=step), self._simulator)

    def _add_body(self, body):
        """Adds a body with its drives. Returns its model instance."""
        plant = self._plant
        parser = Parser(plant=plant, model_name_prefix=body.name)
        (model,) = parser.AddModels(str(body.urdf))
        for name in dict.fromkeys([*body.servos, *body.armature]):
            actuator = plant.AddJointActuator(name, plant.GetJointByName(name, model), math.inf)
            actuator.set_default_gear_ratio(1.0)
            actuator.set_default_rotor_inertia(body.armature.get(name, 0.0))
            servo = body.servos.get(name)
            if servo and not self._options.cenic:
                actuator.set_controller_gains(PdControllerGains(p=servo.kp, d=servo.kd))
        return model

    def _link(self, body, link):
        index = next(k for k, b in enumerate(self._case.bodies) if b.name == body)
        return self._plant.GetBodyByName(link, self._models[index])

    def _actuators(self, model):
        """Actuators of a body, in the order of its ports."""
        return [self._plant.get_joint_actuator(index) for index in self._plant.GetJointActuatorIndices(model)]

    def _connect_servos(self, builder, body, model):
        """Servos of a continuous plant, whose actuators have no gains: effort = y0 + D x, x its state."""
        if not body.servos:
            return
        plant = self._plant
        actuators = self._actuators(model)
        positions, size = plant.num_positions(), plant.num_multibody_states()
        gains = numpy.zeros((len(actuators), size))
        offset = numpy.zeros(len(actuators))
        for row, actuator in enumerate(actuators):
            servo = body.servos.get(actuator.name())
            if servo:
                gains[row, actuator.joint().position_start()] = -servo.kp
                gains[row, positions + actuator.joint().velocity_start()] = -servo.kd
                offset[row] = servo.kp * servo.target
        nothing = numpy.zeros((0, 0))
        servos = builder.AddSystem(AffineSystem(
            A=nothing, B=numpy.zeros((0, size)), f0=numpy.zeros(0), C=numpy.zeros((len(actuators), 0)),
            D=gains, y0=offset,
        ))
        builder.Connect(plant.get_state_output_port(), servos.get_input_port())
        builder.Connect(servos.get_output_port(), plant.get_actuation_input_port(model))

    def _add_contacts(self):
        """Registers shapes of each pair of bodies that touches, and excludes all other contacts."""
        pairs = []
        for friction in self._case.friction:
            coefficients = CoulombFriction(friction.static, friction.kinetic)
            first, second = sorted(friction.bodies, key=lambda name: name != "floor")
            register = lambda name, whole: self._register(name, coefficients, whole)
            whole = self._options.hydroelastic
            pairs.append([register(first, True), register(second, whole)])
            if not whole and first != "floor":
                # Points of each body touch the whole of the other one, never its points.
                pairs.append([register(first, False), register(second, True)])
        declaration = CollisionFilterDeclaration()
        for group in itertools.chain(*pairs):
            declaration.ExcludeWithin(GeometrySet(group))
        for one, other in itertools.combinations(pairs, 2):
            declaration.ExcludeBetween(GeometrySet(sum(one, [])), GeometrySet(sum(other, [])))
        self._scene.collision_filter_manager().Apply(declaration)

    def _register(self, name, friction, whole):
        """Registers the shapes of a body, or the floor, for one pair. Returns their geometry."""
        plant = self._plant
        if name == "floor":
            solids = [(plant.world_body(), HalfSpace(), RigidTransform())]
        else:
            solids = [
                (self._link(name, link), solid, pose)
                for link, shapes in self._case.body(name).touching.items()
                for shape in shapes
                for solid, pose in self._solids(shape, whole, self._case.body(name))
            ]
        geometry = []
        for link, solid, pose in solids:
            label = f"{name} {plant.num_collision_geometries()}"
            properties = self._properties(friction, solid)
            geometry.append(plant.RegisterCollisionGeometry(link, pose, solid, label, properties))
        return geometry

    def _properties(self, friction, solid):
        options = self._options
        properties = ProximityProperties()
        # Stiffnesses of two shapes act in series.
        AddContactMaterial(
            dissipation=None,
            point_stiffness=options.stiffness and 2 * options.stiffness,
            friction=friction,
            properties=properties,
        )
        if options.hydroelastic and isinstance(solid, HalfSpace):
            AddRigidHydroelasticProperties(properties)
        elif options.hydroelastic and not isinstance(solid, Sphere):
            AddCompliantHydroelasticProperties(RESOLUTION, options.modulus, properties)
        return properties

    def _solids(self, shape, whole, body):
        """Drake's shapes of a shape, with their poses in the link."""
        pose = RigidTransform(Quaternion(shape.orientation), shape.position)
        at = lambda point: pose.multiply(RigidTransform(point))
        if shape.kind == "points":
            # The sphere ends at the point when the link is level.
            up = numpy.array([0, 0, POINT_RADIUS])
            return [(Sphere(POINT_RADIUS), at(point + up)) for point in shape.points]
        if shape.kind == "sphere":
            return [(Sphere(shape.radius), pose)]
        if shape.kind == "box" and whole:
            return [(Box(shape.size), pose)]
        if shape.kind == "box":
            half = shape.size / 2 - CORNER_RADIUS
            corners = itertools.product((-1, 1), repeat=3)
            return [(Sphere(CORNER_RADIUS), at(half * signs)) for signs in corners]
        if shape.kind == "cylinder" and whole:
            return [(Cylinder(shape.radius, shape.length), pose)]
        if shape.kind == "cylinder":
            # A lying cylinder touches with the rims of its ends; on its end, a disc has one point of contact.
            root = RigidTransform(Quaternion(body.orientation), body.position)
            if abs(root.multiply(pose).rotation().matrix()[2, 2]) > math.sqrt(0.5):
                raise Unsupported("a cylinder on its end has a single point of contact")
            end = shape.length / 2 - CORNER_RADIUS
            r = shape.radius
            return [(Ellipsoid(r, r, CORNER_RADIUS), at([0, 0, z])) for z in (-end, end)]
        raise Unsupported(f"no shape of kind {shape.kind}")

    def _start(self):
        """Sets the case's start."""
        plant = self._plant
        context = self._context = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        q, v = plant.GetPositions(context), plant.GetVelocities(context)
        self._layout = []
        for body, model in zip(self._case.bodies, self._models):
            links = map(plant.get_body, plant.GetBodyIndices(model))
            (root,) = [link for link in links if link.is_floating_base_body()]
            p, w = root.floating_positions_start(), root.floating_velocities_start_in_v()
            q[p : p + 4], q[p + 4 : p + 7] = body.orientation, body.position
            v[w : w + 3], v[w + 3 : w + 6] = body.angular_velocity, body.linear_velocity
            joints = [plant.GetJointByName(name, model) for name in joint_names(body)]
            positions = [joint.position_start() for joint in joints]
            velocities = [joint.velocity_start() for joint in joints]
            q[positions] = [body.joints.get(joint.name(), 0.0) for joint in joints]
            v[velocities] = [body.joint_velocities.get(joint.name(), 0.0) for joint in joints]
            self._layout.append((p, w, positions, velocities))
            if body.servos and not self._options.cenic:
                servos = [body.servos.get(actuator.name()) for actuator in self._actuators(model)]
                targets = [servo.target if servo else 0.0 for servo in servos]
                plant.get_desired_state_input_port(model).FixValue(context, targets + [0.0] * len(targets))
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        self._simulator.Initialize()

    @property
    def time(self):
        return self._steps * self._step

    def advance(self, steps):
        first, self._steps = self._steps, self._steps + steps
        try:
            # An adaptive integrator stops at each report: results must not depend on `steps`.
            for step in range(first + 1, self._steps) if self._options.cenic else ():
                self._simulator.AdvanceTo(step * self._step)
            self._simulator.AdvanceTo(self.time)
        except (RuntimeError, SystemExit) as error:
            # pydrake raises SystemExit where an assertion of Drake fails.
            raise Failed(str(error)) from error
        if not numpy.isfinite(self._plant.GetPositionsAndVelocities(self._context)).all():
            raise Failed(f"a number is not finite at {self.time:g} s")

    def states(self):
        q = self._plant.GetPositions(self._context)
        v = self._plant.GetVelocities(self._context)
        return [
            BodyState(
                position=q[p + 4 : p + 7],
                # Discrete plants let the norm drift, by 7e-3 in 1 s at 3.6 rad/s and steps of 4 ms.
                orientation=q[p : p + 4] / numpy.linalg.norm(q[p : p + 4]),
                linear_velocity=v[w + 3 : w + 6],
                angular_velocity=v[w : w + 3],
                q=q[positions],
                qd=v[velocities],
            )
            for p, w, positions, velocities in self._layout
        ]
