//! The robot on its floor as a system of differential equations, contact states held fixed.
//!
//! ```text
//! M(q) vdot + h(q, v) = tau + J^T w        w = the contact method's answer to (W, a0)
//! ```
//!
//! One evaluation: kinematics, bias h, mass matrix and its factor, efforts tau, the reduced problem, wrenches,
//! accelerations. `contact.md` section 2: every candidate state is judged with W and a0 alone.

use super::actuator::{self, Stop};
use super::damp::Dampers;
use super::guide::Guide;
use super::impulse::Impulses;
use super::layout::Layout;
use super::setup::{Floor, IntegratorSetup, Setup};
use super::zones::Place;
use crate::contact::methods::contact_method::{ContactSolver, Scheme, StoredEnergy};
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::search::candidate::share_static;
use crate::dynamics::{DynamicsError, State, Workspace, crba, kinematics, reduced, rnea};
use crate::force::{AppliedForces, Force, ForceContext, ReportEvent};
use crate::integrate::System;
use crate::robot::{LinkId, Model, RigidInertia, SoleId};
use crate::task::Command;
use nalgebra::{Vector2, Vector3};
use std::sync::Arc;

/// See the module.
pub struct Plant {
    /// The robot.
    pub model: Arc<Model>,
    /// Gravity, world.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Floor,
    /// Where the state lies in the integrator's vector.
    pub layout: Layout,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// What the joints are asked.
    pub command: Command,
    /// Stiffness of the joint stops; none when limits are ignored.
    pub stops: Option<Vec<Stop>>,
    /// State of the last evaluation.
    pub state: State,
    /// The state that the kinematics in `ws` belong to.
    placed: State,
    /// Dynamics at that state.
    pub ws: Workspace,
    /// W, a0 and sole velocities at that state.
    pub reduced: reduced::Reduced,
    /// The contact problem at that state.
    pub problem: Problem,
    /// Contact states in force.
    pub states: States,
    /// The method's answer.
    pub solution: Solution,
    /// The method.
    pub method: Box<dyn ContactSolver>,
    /// Reference sliding directions, by sole and vertex, from the last choice of states.
    pub directions: Vec<Vec<Vector2<f64>>>,
    /// Where each vertex is on the floor, by sole and vertex; held while a step is integrated.
    pub(super) places: Vec<Vec<Place>>,
    /// Speed below which a sliding vertex is at rest, m/s.
    pub rest: f64,
    /// Error that a step may make in a speed, and relative to it.
    pub(super) step_error: (f64, f64),
    /// A time inside the smooth piece being integrated.
    pub within: f64,
    /// Generalised force without contact and bias, nv.
    pub tau: Vec<f64>,
    /// Actuator efforts per joint.
    pub efforts: Vec<f64>,
    /// The same as `tau` holds them: in an implicit step referred to the velocity before it.
    pub(super) servo: Vec<f64>,
    /// Efforts of damping, friction and stops per joint.
    pub(super) passive: Vec<f64>,
    /// Generalised external force, nv.
    pub(super) external: Vec<f64>,
    /// External force arrows.
    pub arrows: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Generalised acceleration, nv.
    pub acceleration: Vec<f64>,
    /// What the implicit step adds to the diagonal of M; zero for evaluations in continuous time.
    pub(super) shift: Vec<f64>,
    /// What the drives add there, by joint.
    pub(super) drive_give: Vec<f64>,
    /// What friction and stops of the joints add there, by joint.
    pub(super) give: Vec<f64>,
    /// What external forces add there, nv.
    pub(super) external_give: Vec<f64>,
    /// What they add to all of M.
    pub(super) dampers: Dampers,
    /// Joints that a velocity-level step holds on the line of their speed limit.
    pub(super) on_line: Vec<bool>,
    /// Impulses of the floor since the last tick; none when nobody asks.
    pub(super) impulses: Option<Impulses>,
    /// Side of the effort limit, 1 or -1, which a drive reaches within the velocity-level step; 0: none.
    pub(super) saturated: Vec<f64>,
    /// Motions of kinematic joints.
    pub(super) guide: Guide,
    /// Prescribed accelerations, by joint.
    pub(super) demanded: Vec<f64>,
    /// Joints whose actuators lag.
    pub(super) lagging: Vec<usize>,
    /// What was asked of these at the last evaluation, and what the servo adds to `shift`.
    pub(super) asked: Vec<(f64, f64)>,
    pub(super) scratch: Vec<f64>,
    /// Evaluations so far.
    pub evaluations: u64,
    /// Why the last evaluation failed: M could not be factorised and the accelerations are not a number.
    pub failure: Option<DynamicsError>,
}

impl Plant {
    /// Builds the plant of a run; takes the forces out of the setup.
    pub fn new(setup: &mut Setup, method: Box<dyn ContactSolver>, problem: Problem) -> Self {
        let model = setup.model.clone();
        let (nj, nv) = (model.nj(), model.nv());
        let mut state = State::home(&model);
        state.position = setup.start.position;
        state.rotation = setup.start.rotation;
        state.joints.copy_from_slice(&setup.start.joints);
        state.v.copy_from_slice(&setup.start.v);
        let mut ws = Workspace::new(&model);
        kinematics::update(&model, &state, &mut ws);
        crba::mass_matrix(&model, &mut ws);
        let stops = setup.joint_stops.then(|| {
            (0..nj).map(|j| Stop::new(&model.joints[j], ws.mass.get(model.nb() + j, model.nb() + j))).collect()
        });
        let directions = model.soles.iter().map(|s| vec![Vector2::zeros(); s.vertices.len()]).collect();
        let mut plant = Plant {
            layout: Layout::new(&model),
            gravity: setup.gravity,
            floor: setup.floor.clone(),
            forces: std::mem::take(&mut setup.forces),
            command: setup.tasks.command.clone(),
            stops,
            placed: state.clone(),
            state,
            reduced: reduced::Reduced::new(&model, &ws),
            solution: Solution::new(&problem),
            states: States::default(),
            method,
            problem,
            directions,
            places: model.soles.iter().map(|s| vec![Place::default(); s.vertices.len()]).collect(),
            rest: setup.contact.tolerances.rest,
            step_error: match setup.integrator {
                IntegratorSetup::Controlled { relative, absolute, .. } if setup.contact.locate => (absolute, relative),
                // Without located events every step asks what rests.
                _ => (0.0, 0.0),
            },
            within: 0.0,
            tau: vec![0.0; nv],
            efforts: vec![0.0; nj],
            servo: vec![0.0; nj],
            passive: vec![0.0; nj],
            external: vec![0.0; nv],
            arrows: Vec::new(),
            acceleration: vec![0.0; nv],
            shift: vec![0.0; nv],
            drive_give: vec![0.0; nj],
            give: vec![0.0; nj],
            external_give: vec![0.0; nv],
            dampers: Dampers::new(&ws),
            on_line: vec![false; nj],
            impulses: None,
            saturated: vec![0.0; nj],
            guide: Guide::new(nj),
            demanded: vec![0.0; nj],
            asked: vec![(0.0, 0.0); model.lagging().count()],
            lagging: model.lagging().map(|j| j.0).collect(),
            scratch: vec![0.0; nv],
            evaluations: 0,
            failure: None,
            ws,
            model,
        };
        plant.make_room();
        plant
    }

    /// Makes room for all forces that the models may list at one instant.
    pub(super) fn make_room(&mut self) {
        let number = self.forces.iter().map(|force| force.arrows()).sum();
        self.arrows.reserve(number);
        self.dampers.reserve(number);
    }

    /// Everything at `self.state` that does not depend on contact: tau, M and its factor, W, a0, the vertices.
    pub fn evaluate_free(&mut self) {
        self.evaluations += 1;
        self.move_links();
        self.efforts(None);
        self.shift.fill(0.0);
        self.demand(None);
        self.finish_free();
    }

    /// As [`evaluate_free`](Self::evaluate_free) for a velocity-level step of size `dt`: servo, friction and stops are taken
    /// at the end of the step, which adds `dt (kd + d) + dt^2 kp` to the diagonal of M.
    pub fn evaluate_implicit(&mut self, dt: f64) {
        self.evaluations += 1;
        self.move_links();
        self.on_line.fill(false);
        self.saturated.fill(0.0);
        self.pose_implicit(dt);
        // Both are asked: each marks joints.
        if self.enter_band(dt) | self.saturate() {
            self.pose_implicit(dt);
        }
    }

    fn pose_implicit(&mut self, dt: f64) {
        self.efforts(Some(dt));
        let nb = self.model.nb();
        for ((shift, give), drive) in self.shift[nb..].iter_mut().zip(&self.give).zip(&self.drive_give) {
            *shift = give + drive;
        }
        for (shift, give) in self.shift.iter_mut().zip(&self.external_give) {
            *shift += give;
        }
        self.demand(Some(dt));
        self.finish_free();
    }

    /// Brings the kinematics to `self.state`, unless they are there: a fixed step begins where the last one ended.
    pub(super) fn move_links(&mut self) {
        let (state, at) = (&self.state, &mut self.placed);
        at.time = state.time;
        if *at != *state {
            at.copy_from(state);
            kinematics::update(&self.model, state, &mut self.ws);
        }
    }

    /// The links have changed: their kinematics are computed anew when they are next wanted.
    pub(super) fn displaced(&mut self) {
        self.placed.position.x = f64::NAN;
    }

    /// Replaces the inertia of a link at `self.state`.
    pub(super) fn set_body(&mut self, link: LinkId, body: &RigidInertia) {
        let model = Arc::make_mut(&mut self.model);
        model.links[link.0].set_body(body);
        self.problem.scale = load_scale(model, &self.gravity);
        self.placed.copy_from(&self.state);
        kinematics::update(&self.model, &self.state, &mut self.ws);
    }

    /// Fills tau with actuators, passive joint efforts and external forces. With a step size the position servo is
    /// referred to the position that the present velocity leads to, as the implicit step requires.
    fn efforts(&mut self, dt: Option<f64>) {
        let nb = self.model.nb();
        for (j, joint) in self.model.joints.iter().enumerate() {
            let (q, qd) = (self.state.joints[j], self.state.v[nb + j]);
            let (effort, clipped) = match self.saturated[j] {
                _ if dt.is_none() => actuator::servo(joint, j, q, qd, &self.command),
                0.0 => actuator::servo(joint, j, q, qd, &self.command),
                side => (side * joint.effort_limit, true),
            };
            let (ahead, gain) = match dt {
                Some(dt) if !clipped => actuator::implicit(j, qd, &self.command, dt),
                _ => (0.0, 0.0),
            };
            self.efforts[j] = effort;
            self.servo[j] = effort + ahead;
            self.drive_give[j] = gain;
        }
        self.lag_behind(dt);
        self.limit_speeds(dt);
        self.passive.fill(0.0);
        let (stops, joints, rates) = (self.stops.as_deref(), &self.state.joints, &self.state.v[nb..]);
        match dt {
            None => actuator::passive(&self.model, stops, joints, rates, &mut self.passive),
            Some(dt) => {
                let (passive, give) = (&mut self.passive, &mut self.give);
                actuator::passive_implicit(&self.model, stops, joints, rates, dt, passive, give);
            }
        }
        self.external.fill(0.0);
        self.arrows.clear();
        self.dampers.clear();
        let context = ForceContext {
            model: &self.model,
            state: &self.state,
            kinematics: &self.ws,
            gravity: self.gravity,
            // A velocity-level step takes what changes with time at its middle.
            time: if dt.is_some() { self.within } else { self.state.time },
            within: self.within,
        };
        let mut applied = AppliedForces::new(&mut self.external, &mut self.arrows);
        for force in &mut self.forces {
            force.evaluate(&context, &mut applied);
        }
        if let Some(dt) = dt {
            self.external_give.fill(0.0);
            self.forces.iter().for_each(|force| force.damping(&context, &mut self.external_give));
            self.external_give.iter_mut().for_each(|give| *give *= dt);
            self.dampers.gather(&self.forces, &context, dt);
        }
        self.tau.copy_from_slice(&self.external);
        for (tau, (servo, passive)) in self.tau[nb..].iter_mut().zip(self.servo.iter().zip(&self.passive)) {
            *tau += servo + passive;
        }
    }

    /// Calls every force model's `init` at the present state.
    pub(super) fn init_forces(&mut self) -> Result<(), String> {
        (0..self.forces.len()).try_for_each(|i| self.init_force(i))
    }

    /// Adds a force model, and makes room for what it shows.
    pub(super) fn add_force(&mut self, force: Box<dyn Force>) -> Result<(), String> {
        self.forces.push(force);
        self.make_room();
        self.init_force(self.forces.len() - 1)
    }

    /// Calls `init` of one force model at the present state, whose kinematics it brings up to date.
    pub(super) fn init_force(&mut self, i: usize) -> Result<(), String> {
        self.move_links();
        let context = ForceContext {
            model: &self.model,
            state: &self.state,
            kinematics: &self.ws,
            gravity: self.gravity,
            time: self.state.time,
            within: self.within,
        };
        self.forces[i].init(&context).map_err(|e| e.to_string())
    }

    /// Calls every force model's `pass` at the present state, whose kinematics it brings up to date.
    pub(super) fn pass_forces(&mut self, tell: &mut ReportEvent) {
        self.move_links();
        let context = ForceContext {
            model: &self.model,
            state: &self.state,
            kinematics: &self.ws,
            gravity: self.gravity,
            time: self.state.time,
            // The piece that begins here.
            within: self.state.time,
        };
        self.forces.iter_mut().for_each(|force| force.pass(&context, tell));
    }

    fn finish_free(&mut self) {
        rnea::bias(&self.model, &mut self.ws, &self.gravity);
        crba::mass_matrix(&self.model, &mut self.ws);
        self.failure = self.factorize().err();
        if self.reduced.prescribed.is_empty() {
            reduced::assemble(&self.model, &self.ws, &self.floor.rotation, &self.tau, &mut self.reduced);
        } else {
            self.carry_over();
            reduced::assemble(&self.model, &self.ws, &self.floor.rotation, &self.scratch, &mut self.reduced);
        }
        self.acceleration.copy_from_slice(&self.reduced.free);
        if self.failure.is_some() {
            self.acceleration.fill(f64::NAN);
        }
        self.problem.w.copy_from_slice(&self.reduced.w);
        self.problem.b.copy_from_slice(&self.reduced.a0);
        self.place_vertices();
    }

    /// Brings kinematics and vertices to `self.state`; forces stay those of the last step.
    pub fn refresh(&mut self) {
        self.move_links();
        reduced::geometry(&self.model, &self.ws, &self.floor.rotation, &mut self.reduced);
        self.place_vertices();
    }

    /// Copies the vertices into the contact problem, at the acceleration level.
    fn place_vertices(&mut self) {
        let p = &mut self.problem;
        p.level = Level::Acceleration;
        p.step = 0.0;
        for (s, sole) in p.soles.iter_mut().enumerate() {
            sole.target = Vector3::zeros();
            sole.position = self.floor.to_floor(&(self.reduced.reference[s] - self.floor.point));
            let m = &self.reduced.velocity[6 * s..6 * s + 6];
            let (linear, omega) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
            let height = self.floor.height(&self.reduced.reference[s]);
            for (v, arm) in sole.vertices.iter_mut().zip(self.reduced.vertices(SoleId(s))) {
                v.r = *arm;
                v.height = height + v.r.z;
                v.velocity = linear + omega.cross(&v.r);
                v.bias = omega.cross(&omega.cross(&v.r));
                v.moving = v.velocity.xy().norm() > self.rest;
                v.near = false;
            }
        }
    }

    /// Full evaluation at `self.state`: accelerations and contact wrenches with the states held.
    pub fn evaluate(&mut self) {
        self.evaluate_free();
        self.point_directions();
        self.method.respond(&self.problem, &self.states, &mut self.solution);
        self.close();
    }

    /// Do springs stand in for the rigid floor?
    pub fn is_compliant(&self) -> bool {
        self.method.scheme() == Scheme::Compliant
    }

    /// What the springs of a compliant method hold at the state of the last evaluation or refresh.
    pub fn stored(&self) -> StoredEnergy {
        self.method.stored(&self.problem)
    }

    /// Splits the wrenches of static soles over their vertices, unless the method has done so.
    pub fn share_forces(&mut self) {
        if !self.method.gives_vertex_forces() {
            share_static(&self.problem, &self.states, &mut self.solution);
        }
    }

    /// Adds the contact wrenches of the solution to the accelerations.
    pub fn close(&mut self) {
        reduced::apply(&self.model, &self.ws, &mut self.reduced, &self.solution.wrench, &mut self.acceleration);
        if !self.reduced.prescribed.is_empty() {
            self.react();
        }
    }

    /// Kinetic energy of the state's velocity at the configuration of the last evaluation, J.
    pub fn kinetic_energy(&mut self) -> f64 {
        self.ws.mass.multiply(&self.state.v, &mut self.scratch);
        0.5 * self.scratch.iter().zip(&self.state.v).map(|(p, v)| p * v).sum::<f64>()
    }

    /// Reference point of a sole relative to the floor point, floor axes, m.
    pub fn sole_origin(&self, s: usize) -> Vector3<f64> {
        self.floor.to_floor(&(self.reduced.reference[s] - self.floor.point))
    }
}

/// The size of contact forces to expect: the weight, N, or the mass where little or nothing pulls.
pub(super) fn load_scale(model: &Model, gravity: &Vector3<f64>) -> f64 {
    model.mass() * gravity.norm().max(1.0)
}

impl System for Plant {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        let layout = self.layout;
        self.unpack(t, y);
        self.evaluate();
        layout.derivative(y, &self.state.v, &self.acceleration, &self.powers(), dy);
        layout.actuators(dy).iter_mut().zip(self.lag_rates()).for_each(|(rate, lag)| *rate = lag);
        // Where these are does not come from integration.
        self.guide.joints().iter().for_each(|j| layout.hold(*j, dy));
    }
}
