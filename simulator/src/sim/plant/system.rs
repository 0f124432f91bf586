//! The right-hand side of the equations of motion, contact states held fixed.
//!
//! ```text
//! M(q) vdot + h(q, v) = tau + J^T w        w = the contact method's solution for (W, a0)
//! ```
//!
//! One evaluation: kinematics, bias h, mass matrix and its factor, efforts tau, the reduced
//! problem, wrenches, accelerations. Every candidate state is judged with W and a0 only
//! (`docs/contact.md`, section 2).

use super::implicit_dampers::ImplicitDampers;
use super::objects::{ObjectSetup, Objects};
use super::polygon::Polygon;
use super::sole_impulses::SoleImpulses;
use super::state_layout::StateLayout;
use crate::contact::methods::contact_method::{ContactSolver, Scheme, StoredEnergy};
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::residual::{self, Residual};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::model::turning::TurningMode;
use crate::contact::search::static_loads::share_static;
use crate::dynamics::reduced::ContactFrame;
use crate::dynamics::{DynamicsError, State, Workspace, crba, kinematics, reduced, rnea};
use crate::force::Force;
use crate::integrate::System;
use crate::robot::{LinkId, Model, RigidInertia};
use crate::sim::actuation::drives::Drives;
use crate::sim::actuation::joint_efforts::{self, JointStop};
use crate::sim::actuation::kinematic_paths::{Interpolation, KinematicPaths};
use crate::sim::bodies::{Body, Friction, PairRules};
use crate::sim::floor::{Floor, VertexRegion};
use crate::task::Command;
use crate::terrain::Terrain;
use nalgebra::{Vector2, Vector3};
use std::sync::Arc;

/// Description of a plant.
pub struct PlantSetup {
    /// The robot.
    pub model: Arc<Model>,
    /// Gravity, world, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Floor,
    /// Initial state.
    pub state: State,
    /// Objects.
    pub objects: Vec<ObjectSetup>,
    /// Bodies that may touch each other.
    pub bodies: Vec<Body>,
    /// Rules for pairs of bodies.
    pub pair_rules: PairRules,
    /// Fixed bodies besides the floor.
    pub terrain: Arc<Terrain>,
    /// Do joint limits stop the joints?
    pub joint_stops: bool,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// Initial joint commands.
    pub command: Command,
    /// What position servos follow between two commands.
    pub interpolation: Interpolation,
    /// Speed below which a sliding vertex is at rest, m/s.
    pub rest: f64,
    /// Error that a step may make in a speed: absolute, m/s, and relative. Zero without located
    /// events, when every step decides which vertices rest.
    pub step_error: (f64, f64),
}

/// The robot on its floor: state, parameters, and the results of the last evaluation.
pub struct Plant {
    /// The robot.
    pub model: Arc<Model>,
    /// Polygons of the contact problem, in the order of `problem.soles`: the soles, then other links over the
    /// floor, then patches of pairs of bodies.
    pub polygons: Vec<Polygon>,
    /// Bodies that may touch each other.
    pub bodies: Vec<Body>,
    /// Motion of each patch of a pair that the biases of its vertices contain, 6 per polygon.
    pub pair_bias: Vec<[f64; 6]>,
    /// Rules for pairs of bodies, and friction that they give polygons on the floor.
    pub pair_rules: PairRules,
    pub(super) floor_rules: Vec<Option<Friction>>,
    /// Fixed bodies besides the floor.
    pub terrain: Arc<Terrain>,
    /// Gravity, world.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Floor,
    /// Layout of the integrator's vector.
    pub layout: StateLayout,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// Joint commands.
    pub command: Command,
    /// Those of the last evaluation, if servos follow a path between two commands.
    pub(super) interpolated: Command,
    /// Stiffness of the joint stops; none when limits are ignored.
    pub stops: Option<Vec<JointStop>>,
    /// State of the last evaluation.
    pub state: State,
    /// The objects, whose velocities follow the robot's in all vectors of velocities of mechanisms.
    pub objects: Objects,
    /// The state of the kinematics in `ws`.
    pub(super) kinematics_state: State,
    /// Whether soles and vertices belong to that state. The next evaluation clears this: a contact
    /// problem may change the vertices.
    pub(super) refreshed: bool,
    /// Dynamics at that state.
    pub ws: Workspace,
    /// W, a0 and sole velocities at that state.
    pub reduced: reduced::Reduced,
    /// The contact problem at that state.
    pub problem: Problem,
    /// Contact states in force.
    pub states: States,
    /// The method's solution.
    pub solution: Solution,
    /// Whether the forces on the vertices of static soles belong to the solution, not to a rule of
    /// sharing: those of points in a sliding mode.
    pub has_point_forces: bool,
    /// Residuals of the loads of the last velocity-level step, where it was solved.
    pub step_loads: Option<residual::StepLoads>,
    /// The method.
    pub method: Box<dyn ContactSolver>,
    /// Reference sliding directions, by sole and vertex, from the last choice of states.
    pub directions: Vec<Vec<Vector2<f64>>>,
    /// Reference modes of torsional and rolling friction, by polygon, from the last choice of states.
    pub turning: Vec<TurningMode>,
    /// Vertices of each sole, as bits, that have been faster than its `direction_speed` since they
    /// began to slide.
    pub fast_slips: PerSole<u64>,
    /// Friction region of each vertex, by sole and vertex; held while a step is integrated.
    pub(in crate::sim) regions: Vec<Vec<VertexRegion>>,
    /// Speed below which a sliding vertex is at rest, m/s.
    pub rest: f64,
    /// Error that a step may make in a speed, and relative to it.
    pub(super) step_error: (f64, f64),
    /// A time inside the smooth piece being integrated.
    pub within: f64,
    /// Generalised force without contact and bias, of all mechanisms.
    pub tau: Vec<f64>,
    /// The drives and their efforts.
    pub drives: Drives,
    /// Efforts of damping, friction and stops per joint.
    pub(super) passive: Vec<f64>,
    /// Generalised external force, nv.
    pub(super) external: Vec<f64>,
    /// External force arrows.
    pub arrows: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Generalised acceleration, of all mechanisms.
    pub acceleration: Vec<f64>,
    /// Implicit terms of a velocity-level step on the diagonal of M; zero in continuous time.
    pub(super) implicit_diagonal: Vec<f64>,
    /// Implicit terms of friction and stops of the joints, by joint.
    pub(super) implicit_passive: Vec<f64>,
    /// Implicit terms of external forces, nv.
    pub(super) implicit_external: Vec<f64>,
    /// Dampers between points, which add to all of M.
    pub(super) dampers: ImplicitDampers,
    /// Impulses of the floor since the last tick, if a sensor or estimator needs them.
    pub impulses: Option<SoleImpulses>,
    /// Paths of kinematic joints.
    pub kinematic_paths: KinematicPaths,
    /// Prescribed accelerations, by joint.
    pub(super) prescribed_acceleration: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    /// Multipliers of the robot's couplings and loops.
    pub(super) multipliers: Vec<f64>,
    /// Change of all velocities by impulses.
    pub(super) jump: Vec<f64>,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Why the last evaluation failed: M could not be factorised and the accelerations are not a
    /// number.
    pub failure: Option<DynamicsError>,
}

impl Plant {
    /// Builds a plant with a contact method for a problem of its size.
    pub fn new(setup: PlantSetup, method: Box<dyn ContactSolver>, problem: Problem) -> Self {
        let PlantSetup { model, state, .. } = setup;
        let (nj, nv) = (model.nj(), model.nv());
        let mut ws = Workspace::new(&model);
        kinematics::update(&model, &state, &mut ws);
        crba::mass_matrix(&model, &mut ws);
        let stops = setup.joint_stops.then(|| {
            (0..nj).map(|j| JointStop::new(&model.joints[j], ws.mass.get(model.nb() + j, model.nb() + j))).collect()
        });
        let objects = Objects::new(setup.objects, nv);
        let all = objects.list.last().map_or(nv, |object| object.velocities.end);
        let directions = model.soles.iter().map(|s| vec![Vector2::zeros(); s.vertices.len()]).collect();
        let mut plant = Plant {
            layout: StateLayout::new(&model, objects.list.iter().map(|object| &*object.model)),
            gravity: setup.gravity,
            floor: setup.floor,
            forces: setup.forces,
            interpolated: setup.command.clone(),
            command: setup.command,
            stops,
            kinematics_state: state.clone(),
            refreshed: false,
            state,
            reduced: reduced::Reduced::of_contacts(model.soles.iter().map(ContactFrame::Sole), objects.mechanisms(&ws)),
            objects,
            solution: Solution::new(&problem),
            has_point_forces: false,
            step_loads: None,
            states: States::default(),
            method,
            problem,
            directions,
            turning: vec![TurningMode::default(); model.soles.len()],
            fast_slips: PerSole::default(),
            regions: model.soles.iter().map(|s| vec![VertexRegion::default(); s.vertices.len()]).collect(),
            rest: setup.rest,
            step_error: setup.step_error,
            within: 0.0,
            tau: vec![0.0; all],
            drives: Drives::new(&model),
            passive: vec![0.0; nj],
            external: vec![0.0; nv],
            arrows: Vec::new(),
            acceleration: vec![0.0; all],
            implicit_diagonal: vec![0.0; nv],
            implicit_passive: vec![0.0; nj],
            implicit_external: vec![0.0; nv],
            dampers: ImplicitDampers::new(&ws),
            impulses: None,
            kinematic_paths: KinematicPaths::new(nj, setup.interpolation),
            prescribed_acceleration: vec![0.0; nj],
            scratch: vec![0.0; all],
            multipliers: vec![0.0; ws.constraints.number()],
            jump: vec![0.0; all],
            evaluations: 0,
            failure: None,
            ws,
            polygons: model.soles.iter().cloned().map(Polygon::Floor).collect(),
            bodies: setup.bodies,
            pair_bias: Vec::new(),
            pair_rules: setup.pair_rules,
            floor_rules: Vec::new(),
            terrain: setup.terrain,
            model,
        };
        plant.reserve_forces();
        plant.update_floor_rules();
        plant
    }

    /// Evaluates all that does not depend on contact at `self.state`: tau, M and its factor, W, a0,
    /// the vertices.
    pub fn evaluate_free(&mut self) {
        self.evaluations += 1;
        self.update_kinematics();
        self.efforts(None);
        self.implicit_diagonal.fill(0.0);
        self.prescribe_accelerations(None);
        self.refreshed = false;
        self.finish_free(None);
    }

    /// As [`evaluate_free`](Self::evaluate_free) for a velocity-level step of size `dt`. Servo,
    /// friction and stops act at the end of the step, which adds `dt (kd + d) + dt^2 kp` to the
    /// diagonal of M.
    pub fn evaluate_implicit(&mut self, dt: f64) {
        self.evaluations += 1;
        self.update_kinematics();
        // Velocities and impulses of a contact problem replace the accelerations of its vertices.
        self.refreshed &= self.problem.level == Level::Acceleration;
        self.drives.begin_step();
        self.evaluate_implicit_terms(dt);
        let nb = self.model.nb();
        reduced::free(self.objects.mechanisms(&self.ws), &self.reduced, &mut self.acceleration);
        let (rates, free) = (&self.state.v[nb..], &self.acceleration[nb..]);
        // Both are evaluated: each marks joints.
        if self.drives.mark_entering_speed_band(&self.model, rates, free, dt)
            | self.drives.mark_saturated(&self.model, free)
        {
            self.evaluate_implicit_terms(dt);
        }
        self.refreshed = false;
    }

    fn evaluate_implicit_terms(&mut self, dt: f64) {
        self.efforts(Some(dt));
        let nb = self.model.nb();
        let diagonal = &mut self.implicit_diagonal;
        for ((sum, passive), drive) in diagonal[nb..].iter_mut().zip(&self.implicit_passive).zip(&self.drives.implicit)
        {
            *sum = passive + drive;
        }
        for (sum, external) in diagonal.iter_mut().zip(&self.implicit_external) {
            *sum += external;
        }
        self.prescribe_accelerations(Some(dt));
        self.finish_free(Some(dt));
    }

    /// Updates the kinematics to `self.state`, unless they belong to it already: a fixed step
    /// begins where the last one ended.
    pub fn update_kinematics(&mut self) {
        self.refreshed &= !self.objects.update_kinematics();
        let (state, at) = (&self.state, &mut self.kinematics_state);
        at.time = state.time;
        if *at != *state {
            self.refreshed = false;
            at.copy_from(state);
            kinematics::update(&self.model, state, &mut self.ws);
        }
    }

    /// Makes the next update recompute the kinematics, after a change of the links.
    pub(super) fn invalidate_kinematics(&mut self) {
        self.kinematics_state.position.x = f64::NAN;
    }

    /// Replaces the inertia of a link at `self.state`.
    pub fn set_body(&mut self, link: LinkId, body: &RigidInertia) {
        let model = Arc::make_mut(&mut self.model);
        model.links[link.0].set_body(body);
        self.problem.scale = load_scale(model.mass() + self.objects.mass(), &self.gravity);
        self.refreshed = false;
        self.kinematics_state.copy_from(&self.state);
        kinematics::update(&self.model, &self.state, &mut self.ws);
    }

    /// Fills tau with actuators, passive joint efforts and external forces. With a step size the
    /// position servo is referred to the position that the present velocity leads to, as the
    /// implicit step requires.
    fn efforts(&mut self, dt: Option<f64>) {
        let nb = self.model.nb();
        self.interpolate_command(dt.unwrap_or(0.0));
        let (joints, rates) = (&self.state.joints, &self.state.v[nb..]);
        let command = self.kinematic_paths.followed(&self.command, &self.interpolated);
        self.drives.evaluate(&self.model, joints, rates, &self.state.actuators, command, dt);
        self.passive.fill(0.0);
        let stops = self.stops.as_deref();
        match dt {
            None => joint_efforts::passive(&self.model, stops, joints, rates, &mut self.passive),
            Some(dt) => {
                let (passive, implicit) = (&mut self.passive, &mut self.implicit_passive);
                joint_efforts::passive_implicit(&self.model, stops, joints, rates, dt, passive, implicit);
            }
        }
        self.drives.add_motor_friction(&self.model, rates, dt, &mut self.passive);
        self.evaluate_forces(dt);
        let tau = &mut self.tau[..self.model.nv()];
        tau.copy_from_slice(&self.external);
        for (tau, (servo, passive)) in tau[nb..].iter_mut().zip(self.drives.servo.iter().zip(&self.passive)) {
            *tau += servo + passive;
        }
    }

    fn finish_free(&mut self, dt: Option<f64>) {
        self.ws.constraints.set_step(dt);
        rnea::bias(&mut self.ws, &self.gravity);
        crba::mass_matrix(&self.model, &mut self.ws);
        let prescribed = &self.reduced.prescribed;
        let drives = (&*self.model, &self.drives);
        self.failure = self.dampers.factorize(&mut self.ws, drives, &self.implicit_diagonal, prescribed).err();
        let of_objects = self.objects.evaluate(&self.gravity, dt, &mut self.tau);
        self.failure = self.failure.take().or(of_objects.err());
        if !self.refreshed {
            self.update_frames();
        }
        if !self.reduced.prescribed.is_empty() {
            self.move_prescribed_to_right();
        }
        let tau = if self.reduced.prescribed.is_empty() { &self.tau } else { &self.scratch };
        reduced::assemble_with_geometry(self.objects.mechanisms(&self.ws), tau, &mut self.reduced);
        if self.failure.is_some() {
            self.reduced.fail();
        }
        // The same entries are written in each evaluation, and the others are zero.
        // `reduced.w` then has those of the evaluation before.
        std::mem::swap(&mut self.problem.w, &mut self.reduced.w);
        self.problem.b.copy_from_slice(&self.reduced.a0);
        if !self.refreshed {
            self.update_vertices();
        }
        self.add_pair_bias();
    }

    /// Updates the contact frames to the kinematics.
    fn update_frames(&mut self) {
        let mechanisms = self.objects.mechanisms(&self.ws);
        for (s, polygon) in self.polygons.iter_mut().enumerate() {
            if let Polygon::Pair(patch) = polygon {
                patch.update(&self.bodies, mechanisms);
                self.reduced.set_frame(s, patch.axes(), &patch.reference());
            }
        }
        reduced::geometry(mechanisms, &self.floor.rotation, &mut self.reduced);
    }

    /// Updates kinematics and vertices to `self.state`; forces stay those of the last step.
    pub fn refresh(&mut self) {
        self.update_kinematics();
        self.update_frames();
        self.update_vertices();
        self.refreshed = true;
    }

    /// Full evaluation at `self.state`: accelerations and contact wrenches with the states held.
    pub fn evaluate(&mut self) {
        self.evaluate_free();
        self.update_directions();
        self.method.respond(&self.problem, &self.states, &mut self.solution);
        (self.has_point_forces, self.step_loads) = (false, None);
        self.close();
    }

    /// Is the floor compliant?
    pub fn is_compliant(&self) -> bool {
        self.method.scheme() == Scheme::Compliant
    }

    /// Energy stored in the springs of a compliant method, and their power, at the state of the
    /// last evaluation or refresh.
    pub fn stored(&self) -> StoredEnergy {
        self.method.stored(&self.problem)
    }

    /// Distributes the wrenches of static soles over their vertices, unless the method has done so.
    pub fn share_forces(&mut self) {
        if !self.method.gives_vertex_forces() && !self.has_point_forces {
            share_static(&self.problem, &self.states, &mut self.solution);
        }
    }

    /// Residuals of the contact laws at the present state. Shares forces over soles that the last step
    /// has turned, as the log and the next step of `one-step` read them. Where a velocity-level step begins its
    /// states are not those of the velocities before it: creep speed and dissipation gap are zero.
    pub fn residual(&mut self) -> Residual {
        self.share_forces();
        let (p, states, solution) = (&self.problem, &self.states, &self.solution);
        let loads = self.step_loads.map_or_else(|| residual::loads(p, states, solution), |step| step.loads);
        let residual = residual::evaluate_motion(loads, p, states, solution);
        match self.step_loads {
            Some(step) if step.begins => Residual { creep_speed: 0.0, dissipation_gap: 0.0, ..residual },
            _ => residual,
        }
    }

    /// Evaluates the residuals of the loads of a velocity-level step at the state in which it was
    /// solved, which `begins` or ends at the present one. Every method has shared its forces then.
    pub fn evaluate_step_loads(&mut self, begins: bool) {
        let loads = residual::loads(&self.problem, &self.states, &self.solution);
        self.step_loads = Some(residual::StepLoads { loads, begins });
    }

    /// Computes the accelerations for the contact wrenches of the solution.
    pub fn close(&mut self) {
        let mechanisms = self.objects.mechanisms(&self.ws);
        reduced::advance(mechanisms, &mut self.reduced, 1.0, &self.solution.wrench, &mut self.acceleration);
        if !self.reduced.prescribed.is_empty() {
            self.drive_reactions();
        }
    }

    /// Reference point of a sole relative to the floor point, floor axes, m.
    pub fn sole_origin(&self, s: usize) -> Vector3<f64> {
        self.floor.to_floor(&(self.reduced.reference[s] - self.floor.point))
    }
}

/// Scale of the contact forces: the weight of this mass, N, or the mass where gravity is below 1 m/s^2.
pub fn load_scale(mass: f64, gravity: &Vector3<f64>) -> f64 {
    mass * gravity.norm().max(1.0)
}

impl System for Plant {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.unpack(t, y);
        self.evaluate();
        self.write_derivative(y, dy);
    }
}
