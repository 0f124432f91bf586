//! Objects: mechanisms besides the robot, with a state and equations of motion of their own.
//!
//! ```text
//! M_o v_o' + h_o = tau_o + J_o^T w        o = 1, 2, ...
//! ```
//!
//! w are the contact wrenches, which couple objects and robot ([`crate::dynamics::reduced`]). tau_o
//! are external forces and, of objects with joints, efforts of servos that hold a posture, of
//! friction and of stops, by the laws of the robot ([`crate::sim::actuation`]). Velocities of all
//! mechanisms are stacked, the robot's first.

use super::object_forces::ObjectForces;
use crate::dynamics::reduced::Mechanisms;
use crate::dynamics::{DynamicsError, State, Workspace, body, closing, crba, factor, kinematics, rnea};
use crate::robot::{Link, Model};
use crate::sim::actuation::drives::Drives;
use crate::sim::actuation::effort_slopes::DrivesAt;
use crate::sim::actuation::joint_efforts::{self, JointStop};
use crate::task::Command;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::Arc;

/// An object at the start of a run.
#[derive(Clone, Debug)]
pub struct ObjectSetup {
    /// Unique name.
    pub name: String,
    /// Its links.
    pub model: Arc<Model>,
    /// Initial state.
    pub state: State,
    /// Commands of its drives for the whole run.
    pub command: Command,
    /// Do joint limits stop its joints?
    pub joint_stops: bool,
}

/// An object of a run.
#[derive(Clone)]
pub struct Object {
    /// Unique name.
    pub name: String,
    /// Its links.
    pub model: Arc<Model>,
    /// State of the last evaluation.
    pub state: State,
    /// Its velocities among those of all mechanisms.
    pub velocities: Range<usize>,
    /// The state of the kinematics in its workspace.
    kinematics_state: State,
    command: Command,
    drives: Drives,
    stops: Option<Vec<JointStop>>,
    passive: Vec<f64>,
    implicit_passive: Vec<f64>,
    /// External forces at the last evaluation.
    pub(super) external: ObjectForces,
    diagonal: Vec<f64>,
    scratch: Vec<f64>,
}

impl Object {
    fn new(setup: ObjectSetup, first: usize, ws: &mut Workspace) -> Self {
        let ObjectSetup { name, model, state, command, joint_stops } = setup;
        let (nb, nj, nv) = (model.nb(), model.nj(), model.nv());
        kinematics::update(&model, &state, ws);
        crba::mass_matrix(&model, ws);
        Object {
            name,
            velocities: first..first + nv,
            kinematics_state: state.clone(),
            command,
            drives: Drives::new(&model),
            stops: joint_stops
                .then(|| (0..nj).map(|j| JointStop::new(&model.joints[j], ws.mass.get(nb + j, nb + j))).collect()),
            passive: vec![0.0; nj],
            implicit_passive: vec![0.0; nj],
            external: ObjectForces::new(ws),
            diagonal: vec![0.0; nv],
            scratch: vec![0.0; nv],
            model,
            state,
        }
    }

    /// Updates the kinematics to the state. Returns whether they were those of another state.
    fn update_kinematics(&mut self, ws: &mut Workspace) -> bool {
        self.kinematics_state.time = self.state.time;
        if self.kinematics_state == self.state {
            return false;
        }
        self.kinematics_state.copy_from(&self.state);
        kinematics::update(&self.model, &self.state, ws);
        true
    }

    /// Removes the errors of couplings and loops from the state. Returns whether it has any.
    ///
    /// # Errors
    /// A mass matrix that cannot be factorised.
    fn close(&mut self, ws: &mut Workspace) -> Result<bool, DynamicsError> {
        if ws.constraints.number() == 0 {
            return Ok(false);
        }
        closing::project(&self.model, &mut self.state, &[], ws)?;
        self.kinematics_state.copy_from(&self.state);
        Ok(true)
    }

    /// Bias, mass matrix and its factor, and the generalised force in `tau`; with a step size those of a
    /// velocity-level step.
    fn evaluate(
        &mut self,
        ws: &mut Workspace,
        gravity: &Vector3<f64>,
        dt: Option<f64>,
        tau: &mut [f64],
    ) -> Result<(), DynamicsError> {
        ws.constraints.set_step(dt);
        rnea::bias(ws, gravity);
        crba::mass_matrix(&self.model, ws);
        self.drives.begin_step();
        self.efforts(dt, tau);
        self.external.dampers.factorize(ws, (&self.model, &self.drives), &self.diagonal, &[])?;
        let (true, Some(dt)) = (self.model.nj() > 0, dt) else { return Ok(()) };
        for ((free, tau), h) in self.scratch.iter_mut().zip(tau.iter()).zip(&ws.bias) {
            *free = tau - h;
        }
        factor::solve_coupled(ws, &mut self.scratch);
        let nb = self.model.nb();
        let (rates, free) = (&self.state.v[nb..], &self.scratch[nb..]);
        // Both are evaluated: each marks joints.
        if self.drives.mark_entering_speed_band(&self.model, rates, free, dt)
            | self.drives.mark_saturated(&self.model, free)
        {
            self.efforts(Some(dt), tau);
            self.external.dampers.factorize(ws, (&self.model, &self.drives), &self.diagonal, &[])?;
        }
        Ok(())
    }

    fn efforts(&mut self, dt: Option<f64>, tau: &mut [f64]) {
        let nb = self.model.nb();
        let (q, qd) = (&self.state.joints, &self.state.v[nb..]);
        self.drives.evaluate(&self.model, q, qd, &self.state.actuators, &self.command, dt);
        self.passive.fill(0.0);
        let stops = self.stops.as_deref();
        self.diagonal.copy_from_slice(&self.external.implicit);
        match dt {
            None => joint_efforts::passive(&self.model, stops, q, qd, &mut self.passive),
            Some(dt) => {
                let (passive, implicit) = (&mut self.passive, &mut self.implicit_passive);
                joint_efforts::passive_implicit(&self.model, stops, q, qd, dt, passive, implicit);
                let terms = implicit.iter().zip(&self.drives.implicit);
                self.diagonal[nb..].iter_mut().zip(terms).for_each(|(sum, (passive, drive))| *sum += passive + drive);
            }
        }
        self.drives.add_motor_friction(&self.model, qd, dt, &mut self.passive);
        tau.copy_from_slice(&self.external.tau);
        for (tau, (servo, passive)) in tau[nb..].iter_mut().zip(self.drives.servo.iter().zip(&self.passive)) {
            *tau += servo + passive;
        }
    }

    /// Its drives and their state.
    pub(super) fn drives_at(&self) -> DrivesAt<'_> {
        DrivesAt {
            model: &self.model,
            drives: &self.drives,
            passive: &self.passive,
            stops: self.stops.as_deref(),
            joints: &self.state.joints,
            rates: &self.state.v[self.model.nb()..],
            command: &self.command,
        }
    }

    /// Power of its drives, of external forces, and power lost in its joints, W.
    pub fn powers(&self) -> [f64; 3] {
        let rates = &self.state.v[self.model.nb()..];
        let power = |forces: &[f64], v: &[f64]| forces.iter().zip(v).map(|(e, v)| e * v).sum::<f64>();
        let external = power(&self.external.tau, &self.state.v);
        [power(&self.drives.efforts, rates), external, -power(&self.passive, rates)]
    }

    /// Work of its drives and of external forces, and work lost in its joints over a velocity-level step
    /// of size `dt` that changed its velocity by `dv`, J.
    pub fn step_work(&self, dv: &[f64], dt: f64) -> [f64; 3] {
        let nb = self.model.nb();
        let (mut drives, mut joints) = (0.0, 0.0);
        for (j, (servo, passive)) in self.drives.servo.iter().zip(&self.passive).enumerate() {
            let mean = self.state.v[nb + j] - 0.5 * dv[nb + j];
            drives += mean * (dt * servo - self.drives.implicit[j] * dv[nb + j]);
            joints -= mean * (dt * passive - self.implicit_passive[j] * dv[nb + j]);
        }
        let [of_servos, of_friction] = self.drives.coupled_work(&self.model, &self.state.v[nb..], &dv[nb..]);
        (drives, joints) = (drives - of_servos, joints + of_friction);
        [drives, self.external.step_work(&self.state.v, dv, dt), joints]
    }

    /// Rates of its lagging actuators.
    pub fn lag_rates(&self) -> impl Iterator<Item = f64> + '_ {
        self.drives.lag_rates(&self.model, &self.state.actuators)
    }

    /// Ends a velocity-level step of size `dt` that changed its velocity by `dv`.
    pub fn end_step(&mut self, dv: &[f64], dt: f64) {
        let nb = self.model.nb();
        self.drives.average_over_step(&self.model, &dv[nb..], dt);
        self.drives.advance_lag(&self.model, &dv[nb..], dt, &mut self.state.actuators);
    }
}

/// The objects of a run.
#[derive(Default, Clone)]
pub struct Objects {
    /// The objects.
    pub list: Vec<Object>,
    /// Their workspaces.
    pub ws: Vec<Workspace>,
}

impl Objects {
    /// Objects whose velocities follow the first `nv`.
    pub fn new(setups: Vec<ObjectSetup>, nv: usize) -> Self {
        let mut objects = Objects::default();
        let mut first = nv;
        for setup in setups {
            let mut ws = Workspace::new(&setup.model);
            let object = Object::new(setup, first, &mut ws);
            first = object.velocities.end;
            objects.list.push(object);
            objects.ws.push(ws);
        }
        objects
    }

    /// All mechanisms, with the workspace of the robot.
    pub fn mechanisms<'a>(&'a self, robot: &'a Workspace) -> Mechanisms<'a> {
        Mechanisms { robot, objects: &self.ws }
    }

    /// Mass of all, kg.
    pub fn mass(&self) -> f64 {
        self.list.iter().map(|object| object.model.mass()).sum()
    }

    /// Reserves memory for `number` dampers on each.
    pub fn reserve_dampers(&mut self, number: usize) {
        self.list.iter_mut().for_each(|object| object.external.dampers.reserve(number));
    }

    /// Removes all external forces.
    pub fn clear_forces(&mut self) {
        self.list.iter_mut().for_each(|object| object.external.clear());
    }

    /// Gives the implicit terms of external forces the factor `dt`.
    pub fn scale_damping(&mut self, dt: f64) {
        let terms = self.list.iter_mut().flat_map(|object| &mut object.external.implicit);
        terms.for_each(|term| *term *= dt);
    }

    /// Starts lagging actuators at the efforts of their servos.
    pub fn fill_lag(&mut self) {
        for object in &mut self.list {
            let (nb, state) = (object.model.nb(), &mut object.state);
            let (q, qd) = (&state.joints, &state.v[nb..]);
            object.drives.fill_lag(&object.model, q, qd, &object.command, &mut state.actuators);
        }
    }

    /// Sets the time of their states.
    pub fn set_time(&mut self, time: f64) {
        self.list.iter_mut().for_each(|object| object.state.time = time);
    }

    /// Updates all kinematics. Returns whether one was that of another state.
    pub fn update_kinematics(&mut self) -> bool {
        let changed = self.list.iter_mut().zip(&mut self.ws).map(|(object, ws)| object.update_kinematics(ws));
        changed.fold(false, |any, changed| any | changed)
    }

    /// Evaluates all but contact; `tau` is that of all mechanisms.
    ///
    /// # Errors
    /// A mass matrix that cannot be factorised.
    pub fn evaluate(&mut self, gravity: &Vector3<f64>, dt: Option<f64>, tau: &mut [f64]) -> Result<(), DynamicsError> {
        for (object, ws) in self.list.iter_mut().zip(&mut self.ws) {
            let tau = &mut tau[object.velocities.clone()];
            object.evaluate(ws, gravity, dt, tau)?;
        }
        Ok(())
    }

    /// Removes the errors of couplings and loops from the states. Returns whether there are any.
    ///
    /// # Errors
    /// A mass matrix that cannot be factorised.
    pub fn close(&mut self) -> Result<bool, DynamicsError> {
        let mut any = false;
        for (object, ws) in self.list.iter_mut().zip(&mut self.ws) {
            any |= object.close(ws)?;
        }
        Ok(any)
    }

    /// Adds changes of all velocities to those of the objects.
    pub fn add_velocity(&mut self, dv: &[f64]) {
        for object in &mut self.list {
            let dv = &dv[object.velocities.clone()];
            object.state.v.iter_mut().zip(dv).for_each(|(v, dv)| *v += dv);
        }
    }

    /// Moves the configurations by displacements `d` of all mechanisms.
    pub fn displace(&mut self, d: &[f64]) {
        self.list.iter_mut().for_each(|object| object.state.displace(&d[object.velocities.clone()]));
    }

    /// Kinetic energy of the states' velocities at the configurations of the last evaluation, J.
    pub fn kinetic_energy(&mut self) -> f64 {
        let mut sum = 0.0;
        for (object, ws) in self.list.iter_mut().zip(&self.ws) {
            ws.mass.multiply(&object.state.v, &mut object.scratch);
            sum += 0.5 * object.scratch.iter().zip(&object.state.v).map(|(p, v)| p * v).sum::<f64>();
        }
        sum
    }

    /// Kinetic and potential energy of the kinematics, J.
    pub fn energy(&self, gravity: &Vector3<f64>) -> f64 {
        let energy = |(object, ws): (&Object, &Workspace)| {
            body::kinetic_energy(&object.model, ws) + body::potential_energy(ws, gravity)
        };
        self.list.iter().zip(&self.ws).map(energy).sum()
    }
}

/// Links of objects given by name and model, in the order of their poses in a snapshot. The root link has the
/// name of its object, others have it before their own.
pub fn named_links<'a>(objects: impl Iterator<Item = (&'a str, &'a Model)>) -> Vec<Link> {
    let links = objects.flat_map(|(name, model)| {
        model.links.iter().enumerate().map(move |(i, link)| {
            let name = if i == 0 { name.to_owned() } else { format!("{name}/{}", link.name) };
            Link { name, ..link.clone() }
        })
    });
    links.collect()
}
