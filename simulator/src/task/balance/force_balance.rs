//! `balance` with `control = "force"`, and `gravity-compensation`: joint efforts for which the
//! floor supports the robot.
//!
//! ```text
//! F   = m (kp (c_ref - c) + kd (c_ref' - c') - g)          desired force of the floor on the robot           (1)
//! N   = I (kp turn(R, R_ref) - kd omega)                   its desired moment about the centre of mass       (2)
//! f_i : sum f_i = F, sum (p_i - c) x f_i = N, in the friction cones, of least norm  (see distribution)      (3)
//! tau = sum (J_c - J_i)^T f_i                              efforts                                           (4)
//!       + D (kp P(q_ref - q) + kd P(q_ref') - kd q')                                                       (5)
//! ```
//!
//! c is the centre of mass, R and omega orientation and angular velocity of the base, I the total
//! inertia about c, p_i the vertices of the soles, J_c and J_i the Jacobians of c and p_i (columns
//! of the joints), D the diagonal of the mass matrix at the start, P the projection on motions that
//! change no controlled quantity ([`super::null_space_motion`]).
//!
//! Source of (1), (3), (4) and of the damping in (5): [Hyon 2007]. Neither forces nor disturbances
//! are measured, kinematics and dynamics are not inverted, and damping settles the motions that (1)
//! leaves free. (2) and the springs of (5) are additions.
//!
//! **Why it balances.** Gravity's generalised force is `m J_c^T g`, so (4) with `F = m (f_u - g)`
//! reads `tau = h + m J_c^T f_u - sum J_i^T f_i` on the joints, h the bias of the robot at rest.
//! The rows of the base say `0 = h + m J_c^T f_u + (0, N) - sum J_i^T f_i`, which the distribution
//! (3) fulfils. With `f_u` = 0 and N = 0 efforts and contact forces f_i together are an exact
//! equilibrium. If the cones do not allow F and N, (4) uses the allowed forces and stays
//! consistent.

use super::distribution::{Distribution, Measure, Wrench};
use super::null_space_motion::NullSpaceMotion;
use super::reference_trajectory::ReferenceTrajectory;
use super::stance::{Stance, turn_to, upwards};
use crate::dynamics::{Workspace, body, crba, jacobian, kinematics, link_force};
use crate::robot::{DriveMode, JointId, LinkId, Model, SoleId};
use crate::task::{Command, Context, Needs, PointOfInterest, Status, Task, TaskResult, has_elapsed};
use nalgebra::{UnitQuaternion, Vector3};

/// Acceleration per displacement (1/s^2) and per velocity (1/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gains {
    /// Per displacement.
    pub kp: f64,
    /// Per velocity.
    pub kd: f64,
}

/// Settings of the task.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Duration, s; infinity: to the end of the run.
    pub duration: f64,
    /// Centre of mass, equation (1).
    pub com: Gains,
    /// Orientation of the base, (2).
    pub orientation: Gains,
    /// Joints, (5).
    pub joints: Gains,
    /// Offset of the reference of the centre of mass from its default, world, m.
    pub offset: Vector3<f64>,
    /// Time in which the reference moves to its default and offset, s.
    pub approach: f64,
    /// Friction coefficient of (3).
    pub friction: f64,
    /// Distance of the forces of (3) from the edge of the soles: 0 at the edge, 1 in the middle.
    pub margin: f64,
    /// Whether only vertices in contact at the previous tick bear load.
    pub sensed: bool,
}

/// New values at a time of the run; none leaves a value unchanged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// See [`Settings`].
    pub com: Option<Gains>,
    /// See [`Settings`].
    pub orientation: Option<Gains>,
    /// See [`Settings`].
    pub joints: Option<Gains>,
    /// See [`Settings`].
    pub offset: Option<Vector3<f64>>,
    /// For this move of the reference and later ones.
    pub approach: Option<f64>,
    /// See [`Settings`].
    pub friction: Option<f64>,
    /// See [`Settings`].
    pub margin: Option<f64>,
}

/// Task that balances under force control.
pub struct ForceBalance {
    name: &'static str,
    settings: Settings,
    stance: Stance,
    distribution: Distribution,
    null_space: NullSpaceMotion,
    /// Inertia that each joint moves at the start, D.
    inertia: Vec<f64>,
    joints: Vec<JointId>,
    start: f64,
    /// Reference of the centre of mass relative to the centre of the soles, m.
    reference: ReferenceTrajectory<3>,
    /// Times of the changes, s, and their values.
    times: Vec<f64>,
    changes: Vec<Change>,
    orientation: UnitQuaternion<f64>,
    /// Generalised force and joint motion, nv.
    effort: Vec<f64>,
    motion: Vec<f64>,
    /// Desired centre of mass, and the zero-moment point of the forces (3).
    points: [PointOfInterest; 2],
}

impl ForceBalance {
    /// For a robot on `soles` (none: it must have a fixed base); `name` appears in messages;
    /// `changes` by ascending time.
    pub fn new(
        name: &'static str,
        model: &Model,
        soles: Vec<SoleId>,
        settings: Settings,
        changes: Vec<(f64, Change)>,
    ) -> Self {
        let (times, changes): (Vec<f64>, Vec<Change>) = changes.into_iter().unzip();
        let stance = Stance::new(model, soles);
        let vertices = stance.footholds.capacity();
        let driven = |j: &usize| !matches!(model.joints[*j].drive.mode, DriveMode::Passive | DriveMode::Kinematic);
        ForceBalance {
            name,
            distribution: Distribution::new(vertices),
            null_space: NullSpaceMotion::new(0, &[], 0),
            inertia: vec![0.0; model.nj()],
            joints: (0..model.nj()).filter(driven).map(JointId).collect(),
            start: 0.0,
            reference: ReferenceTrajectory::new(1 + changes.len()),
            times,
            changes,
            orientation: UnitQuaternion::identity(),
            effort: vec![0.0; model.nv()],
            motion: vec![0.0; model.nv()],
            settings,
            stance,
            points: ["com", "zmp"].map(|what| PointOfInterest::named(format!("{name}.{what}"))),
        }
    }

    /// Planned contact forces, N, one for each foothold.
    pub fn forces(&self) -> &[Vector3<f64>] {
        self.distribution.forces()
    }

    /// Points of the planned contact forces.
    pub fn stance(&self) -> &Stance {
        &self.stance
    }

    fn update_stance(&mut self, context: &Context) {
        let sensed = (self.settings.sensed && context.time > self.start).then_some(context.sensed);
        let up = upwards(&context.gravity);
        self.stance.update(context.model, &context.data.workspace, self.settings.margin, sensed, &up);
    }

    /// Equations (1) and (2).
    fn desired(&self, context: &Context) -> Wrench {
        let Settings { com, orientation, .. } = &self.settings;
        let data = context.data;
        let inertia = body::total_inertia(&data.workspace);
        let (reference, rate) = self.reference.at(context.time);
        let error = self.stance.centre + reference - data.com;
        let acceleration = error * com.kp + (rate - data.com_velocity) * com.kd - context.gravity;
        let mut moment = Vector3::zeros();
        if context.model.nb() == 6 {
            let v = &context.state.v;
            let spin = turn_to(context.state, &self.orientation) * orientation.kp
                - Vector3::new(v[3], v[4], v[5]) * orientation.kd;
            let c = data.com - data.workspace.position;
            // Inertia about c: that about O less that of the mass at c.
            moment = inertia.rotate(&spin) - c.cross(&spin.cross(&c)) * inertia.mass;
        }
        Wrench { force: acceleration * inertia.mass, moment }
    }

    /// Equation (3). Returns the total force.
    fn distribute(&mut self, context: &Context, desired: &Wrench) -> Vector3<f64> {
        if context.model.nb() == 0 {
            return desired.force;
        }
        self.distribution.clear();
        for hold in &self.stance.footholds {
            self.distribution.add(hold.point - context.data.com, hold.normal);
        }
        let weight = context.model.mass() * context.gravity.norm().max(1.0);
        let centre = self.stance.footholds.iter().map(|h| h.point).sum::<Vector3<f64>>()
            / self.stance.footholds.len().max(1) as f64;
        let reach = self.stance.footholds.iter().map(|h| (h.point - centre).norm_squared()).sum::<f64>()
            / self.stance.footholds.len().max(1) as f64;
        let measure = Measure { force: weight, length: reach.sqrt().max(1e-3), up: upwards(&context.gravity) };
        self.distribution.solve(desired, self.settings.friction, &measure).force
    }

    /// Updates the points shown. Without a spring the centre of mass has no desired position.
    fn update_points(&mut self, context: &Context) {
        let com = self.stance.centre + self.reference.at(context.time).0;
        self.points[0].position = (self.settings.com.kp > 0.0).then_some(com);
        let up = upwards(&context.gravity);
        let (mut sum, mut load) = (Vector3::zeros(), 0.0);
        for (hold, force) in self.stance.footholds.iter().zip(self.distribution.forces()) {
            let part = force.dot(&up);
            sum += hold.point * part;
            load += part;
        }
        self.points[1].position = (context.model.nb() == 6 && load > 0.0).then(|| sum / load);
    }

    /// Equation (4), into `effort`.
    fn set_support_efforts(&mut self, context: &Context, total: &Vector3<f64>) {
        let data = context.data;
        for (effort, column) in self.effort.iter_mut().zip(data.com_jacobian.chunks_exact(3)) {
            *effort = Vector3::from_column_slice(column).dot(total);
        }
        for (hold, f) in self.stance.footholds.iter().zip(self.distribution.forces()) {
            let link = context.model.soles[hold.sole.0].link;
            link_force::accumulate(&data.workspace, link, &hold.point, &-f, &Vector3::zeros(), &mut self.effort);
        }
    }

    /// Equation (5), added to `effort`.
    fn add_joint_control(&mut self, context: &Context, command: &Command) {
        let (nb, gains) = (context.model.nb(), self.settings.joints);
        if gains.kp > 0.0 {
            self.motion.fill(0.0);
            for &JointId(j) in &self.joints {
                self.motion[nb + j] =
                    gains.kp * (command.position[j] - context.q()[j]) + gains.kd * command.velocity[j];
            }
            self.constrain(context);
            self.null_space.project(&mut self.motion);
            for &JointId(j) in &self.joints {
                self.effort[nb + j] += self.inertia[j] * self.motion[nb + j];
            }
        }
        for &JointId(j) in &self.joints {
            self.effort[nb + j] -= self.inertia[j] * gains.kd * context.qd()[j];
        }
    }

    /// Constrains the motions that the springs of the joints must not cause.
    fn constrain(&mut self, context: &Context) {
        let (model, data) = (context.model, context.data);
        let ws = &data.workspace;
        self.null_space.clear();
        for &SoleId(s) in self.stance.soles() {
            let sole = &model.soles[s];
            hold_link(
                &mut self.null_space,
                ws,
                sole.link,
                &ws.point(sole.link, &sole.vertices[0]),
                sole.vertices.len() > 1,
            );
        }
        if self.settings.com.kp > 0.0 {
            (0..3).for_each(|axis| self.null_space.constrain(|k| data.com_jacobian[3 * k + axis]));
        }
        if self.settings.orientation.kp > 0.0 && model.nb() == 6 {
            (0..3).for_each(|axis| self.null_space.constrain(|k| if k == 3 + axis { 1.0 } else { 0.0 }));
        }
    }
}

/// Constrains the position of a point of a link, and the orientation of the link if `oriented`.
fn hold_link(null_space: &mut NullSpaceMotion, ws: &Workspace, link: LinkId, point: &Vector3<f64>, oriented: bool) {
    let chain = ws.support(link);
    for axis in 0..if oriented { 6 } else { 3 } {
        null_space.constrain(|k| {
            if chain.binary_search(&k).is_err() {
                return 0.0;
            }
            let c = jacobian::column(ws, k, point);
            if axis < 3 { c.linear[axis] } else { c.angular[axis - 3] }
        });
    }
}

impl Task for ForceBalance {
    fn init(&mut self, context: &Context, _: &Command) -> TaskResult {
        let model = context.model;
        let (nb, nj) = (model.nb(), model.nj());
        let mut ws = Workspace::new(model);
        kinematics::update(model, context.state, &mut ws);
        crba::mass_matrix(model, &mut ws);
        for j in 0..nj {
            self.inertia[j] = ws.mass.get(nb + j, nb + j);
        }
        // Moving a joint without a drive costs more than all others together, so it stays in place.
        let mut weights = vec![1e6 * self.inertia.iter().fold(0.0, |m: f64, x| m.max(*x)); nj];
        self.joints.iter().for_each(|j| weights[j.0] = self.inertia[j.0]);
        self.null_space = NullSpaceMotion::new(nb, &weights, 6 * self.stance.soles().len() + 6);
        self.start = context.start;
        self.update_stance(context);
        let start = context.data.com - self.stance.centre;
        let up = upwards(&context.gravity);
        let stable = self.stance.stable_point(model, &context.data.workspace, &up) - self.stance.centre;
        self.reference.begin(start);
        let goal = up * start.dot(&up) + stable + self.settings.offset;
        self.reference.add(self.start, self.settings.approach, goal - start);
        self.orientation = context.state.rotation;
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        if has_elapsed(context.time - self.start, self.settings.duration) {
            self.end(context, command);
            return Ok(Status::Done);
        }
        self.update_stance(context);
        let desired = self.desired(context);
        let total = self.distribute(context, &desired);
        self.update_points(context);
        self.set_support_efforts(context, &total);
        self.add_joint_control(context, command);
        let nb = context.model.nb();
        context.model.move_efforts_to_leaders(context.q(), &mut self.effort[nb..]);
        for &JointId(j) in &self.joints {
            command.mode[j] = DriveMode::Force;
            command.effort[j] = self.effort[nb + j];
        }
        Ok(Status::Running)
    }

    /// Servos hold the present posture; the server restores modes and efforts.
    fn end(&mut self, context: &Context, command: &mut Command) {
        for &JointId(j) in &self.joints {
            command.position[j] = context.q()[j];
            command.velocity[j] = 0.0;
        }
    }

    fn change(&mut self, context: &Context, number: usize) -> TaskResult {
        let (change, s) = (&self.changes[number], &mut self.settings);
        s.com = change.com.unwrap_or(s.com);
        s.orientation = change.orientation.unwrap_or(s.orientation);
        s.joints = change.joints.unwrap_or(s.joints);
        s.approach = change.approach.unwrap_or(s.approach);
        s.friction = change.friction.unwrap_or(s.friction);
        s.margin = change.margin.unwrap_or(s.margin);
        if let Some(offset) = change.offset {
            self.reference.add(context.time, s.approach, offset - s.offset);
            s.offset = offset;
        }
        Ok(Status::Running)
    }

    fn adopt_changes(&mut self, newer: Box<dyn Task>) {
        if let Some(newer) = crate::task::of_type::<Self>(newer) {
            self.times = newer.times;
            self.changes = newer.changes;
        }
    }

    fn changes(&self) -> &[f64] {
        &self.times
    }

    fn needs(&self) -> Needs {
        let loads = if self.settings.sensed { Needs::LOADS } else { Needs::NONE };
        Needs::LINKS | Needs::COM | Needs::COM_JACOBIAN | loads
    }

    fn is_temporary(&self) -> bool {
        true
    }

    fn points(&self) -> &[PointOfInterest] {
        &self.points
    }

    fn name(&self) -> &str {
        self.name
    }
}
