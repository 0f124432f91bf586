"""Simulates cases with Pinocchio's dynamics and contact solvers in a time-stepping scheme of this module.

Pinocchio has solvers of contact problems and no simulator. The scheme is that of its examples
(`admm-constraint-solver.py`, `g1-constraint-simulation.py`): semi-implicit Euler with contacts at the level
of velocities. A step of length h solves, with mass matrix M, bias b and Jacobian J of the contacts,

    (M + h kd + h^2 kp) (v+ - v) = h (tau - b) + J^T l,    q+ = q + h v+,
    a = J v+ + s,  N >= 0, a_n >= 0, N a_n = 0,  |t| <= mu N, t = -mu N a_t / |a_t| where a_t is not zero,

where l = (t, N) are impulses. The shift s along the normal is one of

- gap / h for an open contact, which may close exactly at the end of the step (Stewart and Trinkle);
- 0.2 gap / h for a penetration, of which a step removes a fifth (Baumgarte);
- e times the normal velocity before the step, if e > 0 and the contact closes in the step (Moreau).

Servos are implicit: tau = kp (target - q+) - kd v+. Forces are those at the middle of the step.

One item differs from the examples. Their update of a free-flyer in its own axes, v+ = v + h dv/dt and
`integrate(q, h v+)`, does not conserve momentum: a body that spins at w gains speed at a rate of h w^2 / 2.
Here the axes stand still during the step, and the position of the root moves along its new velocity.
"""

import itertools
from collections import namedtuple
from dataclasses import dataclass

import numpy
import pinocchio as pin

from ..engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported
from ..urdf import joint_names

#: Part of a penetration that a step removes.
CORRECTION = 0.2
#: Tolerance and greatest number of iterations of the solvers, and the greatest residual that is accepted.
#: Problems are scaled: the mean diagonal of the Delassus matrix and the greatest velocity are 1.
TOLERANCE, ITERATIONS, ACCEPTED = 1e-10, 20000, 1e-5
#: Contacts are those that close within a step at twice their speed and this acceleration, m/s^2.
ACCELERATION = 100.0
PAIRS = {("box", "box"), ("sphere", "box"), ("points", "box"), ("sphere", "sphere"), ("points", "sphere")}
CORNERS = numpy.array(list(itertools.product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True)
class Attached:
    """A shape in the frame of its joint. `reach`: greatest distance of its surface from the joint."""

    name: str
    joint: int
    placement: pin.SE3
    shape: object
    reach: float

    def pose(self, data):
        pose = data.oMi[self.joint] * self.placement
        return pose.rotation, pose.translation

    def speed(self, data):
        """Upper bound of the speeds of its surface."""
        motion = data.v[self.joint]
        return numpy.linalg.norm(motion.linear) + self.reach * numpy.linalg.norm(motion.angular)


#: A point where joint `first` may touch `second` (0: the floor). Rows of `axes`: tangents, normal to `first`.
Contact = namedtuple("Contact", "key first second point axes gap friction")


def _reach(shape):
    """Greatest distance of a shape's surface from its frame's origin."""
    if shape.kind == "points":
        return numpy.linalg.norm(shape.points, axis=1).max()
    if shape.kind == "box":
        return numpy.linalg.norm(shape.size) / 2
    if shape.kind in ("sphere", "cylinder"):
        return numpy.hypot(shape.radius, (shape.length or 0.0) / 2)
    raise Unsupported(f"shape {shape.kind}")


def _lowest(shape, rotation, position):
    """Points of a shape that can touch the floor: always as many, in the same order."""
    if shape.kind == "points":
        return position + shape.points @ rotation.T
    if shape.kind == "box":
        return position + (CORNERS * shape.size) @ rotation.T
    if shape.kind == "sphere":
        return position[None] - [0, 0, shape.radius]
    # Four points of both rims: the lowest, and those a quarter and a half of a turn from it.
    axis = rotation[:, 2]
    down = axis * axis[2] - [0, 0, 1]
    tilt = numpy.linalg.norm(down)
    down = down / tilt if tilt > 1e-9 else rotation[:, 0]
    side = numpy.cross(axis, down)
    rim = shape.radius * numpy.array([down, side, -down, -side])
    return position + numpy.vstack([rim + axis * shape.length / 2, rim - axis * shape.length / 2])


def _axes(normal):
    """Two tangents and the normal, as rows."""
    first = numpy.cross(numpy.eye(3)[numpy.argmin(numpy.abs(normal))], normal)
    first /= numpy.linalg.norm(first)
    return numpy.array([first, numpy.cross(normal, first), normal])


def _ball_box(center, radius, rotation, position, half, rounding=0.0):
    """Point, normal from the box and gap. A box without edges and with a `rounding` is a sphere."""
    local = rotation.T @ (center - position)
    nearest = numpy.clip(local, -half, half)
    distance = numpy.linalg.norm(local - nearest)
    if distance > 1e-12:
        normal = (local - nearest) / distance
    else:
        k = numpy.argmin(half - numpy.abs(local))
        normal = numpy.eye(3)[k] * (1.0 if local[k] >= 0 else -1.0)
        distance = abs(local[k]) - half[k]
        nearest = local - normal * distance
    gap = distance - radius - rounding
    return position + rotation @ (nearest + normal * (rounding + gap / 2)), rotation @ normal, gap


def _box_box(a, b):
    """Points, normals from box b to box a and gaps: separating axes, then clipping of the touching faces."""
    (ra, pa, ha), (rb, pb, hb) = a, b
    apart = pa - pb

    def along(axis):
        axis = axis if axis @ apart >= 0 else -axis
        return axis @ apart - ha @ numpy.abs(ra.T @ axis) - hb @ numpy.abs(rb.T @ axis), axis

    face_a = max((along(ra[:, k]) for k in range(3)), key=lambda face: face[0])
    face_b = max((along(rb[:, k]) for k in range(3)), key=lambda face: face[0])
    for i, j in itertools.product(range(3), repeat=2):
        axis = numpy.cross(ra[:, i], rb[:, j])
        size = numpy.linalg.norm(axis)
        gap, normal = along(axis / size) if size > 1e-6 else (-numpy.inf, None)
        # Two edges touch if they separate the boxes by more than any face, with a margin for parallel edges.
        if gap > max(face_a[0], face_b[0]) + 1e-5:
            on_a = pa - ra @ (ha * numpy.sign(ra.T @ normal) * (numpy.arange(3) != i))
            on_b = pb + rb @ (hb * numpy.sign(rb.T @ normal) * (numpy.arange(3) != j))
            along_a = numpy.linalg.solve(numpy.column_stack([ra[:, i], -rb[:, j], -normal]), on_b - on_a)[0]
            return [(on_a + along_a * ra[:, i] - normal * gap / 2, normal, gap)]
    # `outward` is the normal of the reference face, away from its box.
    if face_b[0] + 1e-9 >= face_a[0]:
        (rr, pr, hr), (ri, pi, hi), normal, outward = b, a, face_b[1], face_b[1]
    else:
        (rr, pr, hr), (ri, pi, hi), normal, outward = a, b, face_a[1], -face_a[1]
    k = numpy.argmax(numpy.abs(ri.T @ outward))
    u, v = (ri * hi)[:, (k + 1) % 3], (ri * hi)[:, (k + 2) % 3]
    middle = pi - (ri * hi)[:, k] * numpy.sign(ri[:, k] @ outward)
    polygon = [middle + u + v, middle - u + v, middle - u - v, middle + u - v]
    r = numpy.argmax(numpy.abs(rr.T @ outward))
    for axis, sign in itertools.product((k for k in range(3) if k != r), (1, -1)):
        plane = sign * rr[:, axis]
        heights = [plane @ (p - pr) - hr[axis] for p in polygon]
        clipped = []
        for n, (p, height) in enumerate(zip(polygon, heights)):
            before, earlier = polygon[n - 1], heights[n - 1]
            if (height > 1e-9) != (earlier > 1e-9):
                clipped.append(before + (p - before) * (earlier / (earlier - height)))
            if height <= 1e-9:
                clipped.append(p)
        polygon = clipped
    gaps = [outward @ (p - pr) - hr[r] for p in polygon]
    return [(p - outward * gap / 2, normal, gap) for p, gap in zip(polygon, gaps)]


def _between(a, pose_a, b, pose_b):
    """Points, normals from shape b to shape a and gaps."""
    if a.kind == "box":
        return _box_box((*pose_a, a.size / 2), (*pose_b, b.size / 2))
    balls = pose_a[1] + (a.points @ pose_a[0].T if a.kind == "points" else numpy.zeros((1, 3)))
    half, rounding = (b.size / 2, 0.0) if b.kind == "box" else (numpy.zeros(3), b.radius)
    return [_ball_box(ball, a.radius or 0.0, *pose_b, half, rounding) for ball in balls]


def _quaternion(wxyz):
    return pin.Quaternion(*wxyz).normalized()


class ContactSolver:
    """One of Pinocchio's solvers. Starts from the last step's impulses of the same contacts."""

    def __init__(self, name):
        self.admm = name == "admm"
        if self.admm:
            self.solver, self.result_type = pin.ADMMConstraintSolver(), pin.ADMMSolverResult
            self.settings = pin.ADMMSolverSettings()
            self.settings.admm_update_rule = pin.ADMMUpdateRule.SPECTRAL
        else:
            self.solver, self.result_type = pin.PGSConstraintSolver(), pin.PGSSolverResult
            self.settings = pin.PGSSolverSettings()
        self.settings.solve_ncp = True
        self.settings.max_iterations = ITERATIONS
        self.settings.absolute_feasibility_tol = self.settings.absolute_complementarity_tol = TOLERANCE
        self.settings.relative_feasibility_tol = self.settings.relative_complementarity_tol = 0
        self.models, self.last = {}, {}

    def cones(self, frictions):
        """Constraint models and data for the friction cones; the solver takes no geometry from them."""
        if frictions not in self.models:
            models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
            for friction in frictions:
                point = pin.PointContactConstraintModel(pin.Model(), 0, 0)
                point.setFriction(friction)
                point.setCompliance(numpy.zeros(3))
                models.append(pin.ConstraintModel(point))
                datas.append(models[len(models) - 1].createData())
            self.models[frictions] = models, datas
        return self.models[frictions]

    def solve(self, delassus, drift, contacts):
        """Impulses with velocities `delassus` impulses + `drift`. Raises `Failed`."""
        frictions = tuple(c.friction for c in contacts)
        weight, size = numpy.trace(delassus) / len(drift), numpy.abs(drift).max()
        if not numpy.isfinite(weight * size):
            raise Failed("the contact problem is not finite")
        if size == 0:
            return numpy.zeros(len(drift))
        delassus, drift = delassus / weight, drift / size
        guess = numpy.concatenate([self.last.get(c.key, numpy.zeros(3)) for c in contacts]) * weight / size
        if not self.admm:
            self.settings.over_relaxation = self.relaxation(delassus)
        # The second attempt starts from zero.
        for start in (guess, None) if guess.any() else (None,):
            result = self.result_type()
            if start is not None:
                result.resize(len(drift))
                result.setConstraintImpulseGuess(start)
            problem = pin.DelassusOperatorDense(delassus), drift, *self.cones(frictions)
            self.solver.solve(*problem, self.settings, result)
            impulses = numpy.array(result.retrieveConstraintImpulses())
            residual = self.residual(delassus, drift, impulses, numpy.array(frictions))
            if residual <= ACCEPTED:
                impulses *= size / weight
                self.last = {c.key: impulses[3 * k : 3 * k + 3] for k, c in enumerate(contacts)}
                return impulses
        raise Failed(f"the contact solver did not converge: residual {residual:.1e}")

    @staticmethod
    def relaxation(delassus):
        """Relaxation of PGS: the tangential step 1 / min(G_11, G_22) becomes at most 1 / eigenvalue."""
        k = numpy.arange(0, len(delassus), 3)
        xx, yy, xy = delassus[k, k], delassus[k + 1, k + 1], delassus[k, k + 1]
        greatest = (xx + yy) / 2 + numpy.hypot((xx - yy) / 2, xy)
        return (numpy.minimum(xx, yy) / greatest).min()

    @staticmethod
    def residual(delassus, drift, impulses, frictions):
        """Greatest distance of l from the projection of l - (a + mu |a_t| n) on the cones."""
        l, mu = impulses.reshape(-1, 3), frictions
        x = l - (delassus @ impulses + drift).reshape(-1, 3)
        x[:, 2] -= mu * numpy.linalg.norm((l - x)[:, :2], axis=1)
        t = numpy.linalg.norm(x[:, :2], axis=1)
        normal = numpy.where(t <= mu * x[:, 2], x[:, 2], numpy.maximum((mu * t + x[:, 2]) / (1 + mu**2), 0))
        shrink = numpy.minimum(mu * normal / numpy.maximum(t, 1e-300), 1.0)
        return numpy.abs(l - numpy.column_stack([x[:, :2] * shrink[:, None], normal])).max()


class PinocchioSimulation(Simulation):
    """A case in the scheme. `x` has positions of roots and joints, `v` velocities; those of roots are linear
    in world axes, angular in root axes. `roots` has first columns in q and v, and columns of joints in v."""

    def __init__(self, case, solver, step):
        self.case, self.step, self.count = case, step, 0
        self.solver = ContactSolver(solver)
        self.model = self._build(case)
        self.data, self.neutral = self.model.createData(), pin.neutral(self.model)
        self.x, self.v, self.kp, self.kd, self.target, armature = numpy.zeros((6, self.model.nv))
        self.roots, self.turns = [], []
        for body in case.bodies:
            names = joint_names(body)
            find = lambda name: self.model.joints[self.model.getJointId(f"{body.name}/{name}")]
            root, *joints = [find(name) for name in ("root_joint", *names)]
            if any(joint.nv != 1 for joint in joints):
                raise Unsupported("joints with more than one degree of freedom")
            self.roots.append((root.idx_q, root.idx_v, [joint.idx_v for joint in joints]))
            self.turns.append(_quaternion(body.orientation))
            self.x[root.idx_v : root.idx_v + 3] = body.position
            self.v[root.idx_v : root.idx_v + 3] = body.linear_velocity
            self.v[root.idx_v + 3 : root.idx_v + 6] = self.turns[-1].matrix().T @ body.angular_velocity
            for name, k in zip(names, self.roots[-1][2]):
                self.x[k] = body.joints.get(name, 0.0)
                self.v[k] = body.joint_velocities.get(name, 0.0)
                armature[k] = body.armature.get(name, 0.0)
                if servo := body.servos.get(name):
                    self.kp[k], self.kd[k], self.target[k] = servo.kp, servo.kd, servo.target
        self.model.armature = armature
        self.implicit = numpy.diag(step * self.kd + step**2 * self.kp)
        self.forces = [(force, *self._link(force.body, force.link)) for force in case.forces]
        self.floor, self.pairs = self._touching()

    @staticmethod
    def _build(case):
        whole = None
        for body in case.bodies:
            model = pin.buildModelFromUrdf(str(body.urdf), pin.JointModelFreeFlyer())
            # Names are those of the body's file: several bodies may share a file.
            for k in range(1, model.njoints):
                model.names[k] = f"{body.name}/{model.names[k]}"
            for frame in model.frames:  # A slice would be a copy.
                frame.name = f"{body.name}/{frame.name}"
            whole = model if whole is None else pin.appendModel(whole, model, 0, pin.SE3.Identity())
        whole.gravity.linear = case.gravity
        return whole

    def _link(self, body, link):
        """Joint that moves a link, and the placement of the link's frame in it."""
        frame = self.model.frames[self.model.getFrameId(f"{body}/{link}", pin.FrameType.BODY)]
        return frame.parentJoint, frame.placement

    def _touching(self):
        """Shapes on the floor with their friction, and pairs of shapes with theirs."""
        shapes, floor, pairs = {body.name: [] for body in self.case.bodies}, [], []
        for body in self.case.bodies:
            for link, on_link in body.touching.items():
                joint, placement = self._link(body.name, link)
                for number, shape in enumerate(on_link):
                    own = placement * pin.SE3(_quaternion(shape.orientation).matrix(), shape.position)
                    reach = numpy.linalg.norm(own.translation) + _reach(shape)
                    name = f"{body.name}/{link}/{number}"
                    shapes[body.name].append(Attached(name, joint, own, shape, reach))
        for friction in self.case.friction:
            first, second = sorted(friction.bodies, key=lambda name: name == "floor")
            if second == "floor":
                floor += [(shape, friction.static) for shape in shapes[first]]
                continue
            for a, b in itertools.product(shapes[first], shapes[second]):
                a, b = (a, b) if (a.shape.kind, b.shape.kind) in PAIRS else (b, a)
                if (a.shape.kind, b.shape.kind) not in PAIRS:
                    raise Unsupported(f"contact of {a.shape.kind} and {b.shape.kind}")
                pairs.append((a, b, friction.static))
        return floor, pairs

    @property
    def time(self):
        return self.count * self.step

    def advance(self, steps):
        for _ in range(steps):
            self._advance()
            self.count += 1
            if not (numpy.isfinite(self.x).all() and numpy.isfinite(self.v).all()):
                raise Failed("the state is not finite")

    def _evaluate(self):
        """Evaluates the model at the state. Returns Pinocchio's v, in axes of the roots."""
        v, turned = self.v.copy(), self.x.copy()
        for _, k, _ in self.roots:
            turned[k : k + 6] = 0
        q = pin.integrate(self.model, self.neutral, turned)
        for (first, k, _), turn in zip(self.roots, self.turns):
            v[k : k + 3] = turn.matrix().T @ v[k : k + 3]
            q[first : first + 7] = [*self.x[k : k + 3], *turn.coeffs()]
        pin.computeAllTerms(self.model, self.data, q, v)
        return v

    def _jacobian(self, joint, point):
        """Jacobians of a point's velocity and of the angular velocity, world axes."""
        if joint == 0:
            return numpy.zeros((3, self.model.nv)), numpy.zeros((3, self.model.nv))
        jacobian = pin.getJointJacobian(self.model, self.data, joint, pin.LOCAL_WORLD_ALIGNED)
        arm = pin.skew(point - self.data.oMi[joint].translation)
        return jacobian[:3] - arm @ jacobian[3:], jacobian[3:]

    def _contacts(self):
        """Points that may close within the step."""
        h, found = self.step, []
        margin = lambda speed: h * (2 * speed + h * ACCELERATION)
        for shape, friction in self.floor:
            points = _lowest(shape.shape, *shape.pose(self.data))
            for k in numpy.nonzero(points[:, 2] < margin(shape.speed(self.data)))[0]:
                key = (shape.name, k)
                found.append(Contact(key, shape.joint, 0, points[k], numpy.eye(3), points[k, 2], friction))
        for a, b, friction in self.pairs:
            near = margin(a.speed(self.data) + b.speed(self.data))
            points = _between(a.shape, a.pose(self.data), b.shape, b.pose(self.data))
            for k, (point, normal, gap) in enumerate(points):
                if gap < near:
                    key = (a.name, b.name, k)
                    found.append(Contact(key, a.joint, b.joint, point, _axes(normal), gap, friction))
        return found

    def _efforts(self, v):
        """Efforts of servos at the end of the step if v were constant, and forces at its middle."""
        tau = self.kp * (self.target - self.x - self.step * v) - self.kd * v
        for force, joint, placement in self.forces:
            push, moment = force.at(self.time + self.step / 2)
            linear, angular = self._jacobian(joint, (self.data.oMi[joint] * placement).act(force.point))
            tau += linear.T @ push + angular.T @ moment
        return tau

    def _advance(self):
        h, v = self.step, self._evaluate()
        mass = self.data.M + self.implicit
        after = v + h * numpy.linalg.solve(mass, self._efforts(v) - self.data.nle)
        for _, k, _ in self.roots:
            # Pinocchio's acceleration of a root is relative to its turning axes.
            after[k : k + 3] += h * numpy.cross(v[k + 3 : k + 6], v[k : k + 3])
        contacts = self._contacts()
        if contacts:
            after += self._impulses(contacts, mass, v, after)
        for n, (_, k, _) in enumerate(self.roots):
            after[k : k + 3] = self.turns[n].matrix() @ after[k : k + 3]
            turn = pin.Quaternion(pin.exp3(h * after[k + 3 : k + 6]))
            self.turns[n] = (self.turns[n] * turn).normalized()
        self.v = after
        self.x += h * after

    def _impulses(self, contacts, mass, v, free):
        """Changes of velocities by the contacts."""
        jacobian = lambda c: self._jacobian(c.first, c.point)[0] - self._jacobian(c.second, c.point)[0]
        rows = numpy.vstack([c.axes @ jacobian(c) for c in contacts])
        response = numpy.linalg.solve(mass, rows.T)
        delassus, drift, before = rows @ response, rows @ free, rows @ v
        for n, c in zip(range(2, len(drift), 3), contacts):
            if self.case.restitution > 0 and before[n] < 0 and c.gap + self.step * drift[n] <= 0:
                drift[n] += self.case.restitution * before[n]
            else:
                drift[n] += c.gap / self.step * (CORRECTION if c.gap < 0 else 1.0)
        return response @ self.solver.solve((delassus + delassus.T) / 2, drift, contacts)

    def states(self):
        states = []
        for (_, k, joints), turn in zip(self.roots, self.turns):
            x, y, z, w = turn.coeffs()
            position, linear = self.x[k : k + 3].copy(), self.v[k : k + 3].copy()
            orientation, angular = numpy.array([w, x, y, z]), turn.matrix() @ self.v[k + 3 : k + 6]
            states.append(BodyState(position, orientation, linear, angular, self.x[joints], self.v[joints]))
        return states


class Adapter(Engine):
    """Pinocchio's contact solvers in a time-stepping scheme."""

    name = "pinocchio"
    package = "pin"

    def version(self):
        return pin.__version__

    def settings(self):
        solvers = {"admm": "ADMM", "pgs": "projected Gauss-Seidel"}
        scheme = f"semi-implicit Euler, contacts at a scaled tolerance of {TOLERANCE:g}, implicit servos"
        return [Settings(name, f"{solver}; {scheme}") for name, solver in solvers.items()]

    def simulation(self, case, settings, step):
        if case.has_two_coefficients:
            raise Unsupported("one coefficient of friction")
        return PinocchioSimulation(case, settings.name, step)
