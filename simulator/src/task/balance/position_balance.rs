//! `balance` for robots that follow positions: feedback of the centre of mass through its Jacobian.
//!
//! ```text
//! e = r - c,   d = r - p                      r reference, c centre of mass, p zero-moment point, as sensed; horizontal
//! w' = k_i e + k_z d  while all soles are flat    k_i: return to the reference;  k_z: lean until the load is over it
//! u = w + k_p e - k_d c'                      |u|, |w| <= reach per axis
//! dq = z + W J^T (J W J^T + mu 1)^-1 (x - J z),   J = [J_soles; J_com,xy],   x = [0; r + u - c_plan],   z = k_q (q_0 - q) dt
//! ```
//!
//! The commanded posture q of the plan keeps the soles in place and the centre of mass at r + u.
//! Joints that this leaves free return to their initial posture q_0, and W weights the joints'
//! shares. r is above the point of optimal stability of the soles' common hull and moves with the
//! soles; the point of whole soles moves a robot on its toes back over its feet. While a sole is on
//! an edge w is constant: the position of the load is unknown. At rest d = e, so either integral brings the sensed centre of mass to r regardless of the
//! servos' sag. Under a lasting push only d shows how far to lean.
//!
//! An accelerated centre of mass first moves the zero-moment point the wrong way, p = c - c'' h/g.
//! k_z therefore has to stay well below sqrt(g/h): by default it is at most a third of that, and
//! k_d at least 3.6 1/s times h/g.
//!
//! Sources: [Sugihara 2002] (the centre of mass resolved by its Jacobian, with fixed feet); [Hale
//! 2008], section II.B (centre-of-mass feedback of position-actuated robots).

use super::reference_trajectory::ReferenceTrajectory;
use crate::geometry::{convex_hull, stable_point};
use crate::motion::minimum_jerk::minimum_jerk;
use crate::robot::{Model, SoleId};
use crate::task::kinematic::{Goal, InverseKinematics, PlannedRobot, Unknowns, feed_forward, planned_robot};
use crate::task::{Command, Context, Needs, PointOfInterest, Status, Task, TaskResult, has_elapsed};
use nalgebra::{Vector2, Vector3};

/// Default k_z as a fraction of sqrt(g/h), the rate of the robot as an inverted pendulum, and its
/// maximum, 1/s. HOAP-2 has 6 1/s, robots of human size 3.5 1/s.
const LEANING: (f64, f64) = (1.0 / 3.0, 2.0);
/// Default k_d over h/g, 1/s, and its minimum, s.
const DAMPING: (f64, f64) = (3.6, 0.1);

/// Settings of the task.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Duration, s; may be infinite.
    pub duration: f64,
    /// k_p, m per m.
    pub proportional: f64,
    /// k_d, s; none: `DAMPING` times h/g, at least 0.1.
    pub damping: Option<f64>,
    /// k_i, 1/s.
    pub integral: f64,
    /// k_z, 1/s; none: `LEANING` times sqrt(g/h), at most 2.
    pub leaning: Option<f64>,
    /// Greatest displacement u per axis, m.
    pub reach: f64,
    /// k_q, 1/s.
    pub posture: f64,
    /// Time in which the control takes full effect, s.
    pub approach: f64,
    /// Displacement of r from its default, world axes, m.
    pub offset: Vector2<f64>,
    /// W of each joint.
    pub mobility: Vec<f64>,
    /// Whether joints get efforts against gravity in addition to positions.
    pub feed_forward: bool,
}

/// New values at a time of the run; none leaves a value unchanged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// k_p, m per m.
    pub proportional: Option<f64>,
    /// k_d, s.
    pub damping: Option<f64>,
    /// k_i, 1/s.
    pub integral: Option<f64>,
    /// k_z, 1/s.
    pub leaning: Option<f64>,
    /// k_q, 1/s.
    pub posture: Option<f64>,
    /// Displacement of r from its default, world axes, m.
    pub offset: Option<Vector2<f64>>,
    /// Time in which r moves there, also for later changes, s.
    pub approach: Option<f64>,
}

/// Task that balances under position control.
pub struct PositionBalance {
    settings: Settings,
    /// Present k_d and k_z.
    damping: f64,
    leaning: f64,
    soles: Vec<SoleId>,
    planned: PlannedRobot,
    goal: Goal,
    inverse: InverseKinematics,
    joints: Vec<usize>,
    carrying: Vec<usize>,
    efforts: Vec<f64>,
    hull: Vec<Vector3<f64>>,
    edges: Vec<stable_point::Edge>,
    started: f64,
    /// Time of the last tick, s.
    last_tick: f64,
    posture: Vec<f64>,
    /// r relative to the mean of the soles, starting at the planned centre of mass.
    reference: ReferenceTrajectory<2>,
    /// Times of the changes, s, and their values.
    times: Vec<f64>,
    changes: Vec<Change>,
    /// Whether it ever reads the zero-moment point.
    reads_zmp: bool,
    /// Time in which the control takes full effect, s.
    rise: f64,
    /// The integral w.
    integral: Vector2<f64>,
    /// Desired centre of mass, r at the height of the plan, and desired zero-moment point, r on the
    /// ground.
    points: [PointOfInterest; 2],
}

impl PositionBalance {
    /// For a robot that [`planned_robot::check`] accepts, on one or more `soles`; `changes` by
    /// ascending time.
    pub fn new(model: &Model, soles: Vec<SoleId>, settings: Settings, changes: Vec<(f64, Change)>) -> Self {
        let (times, changes): (Vec<f64>, Vec<Change>) = changes.into_iter().unzip();
        let leans = |leaning: Option<f64>| leaning != Some(0.0);
        let planned = PlannedRobot::on(model, &soles);
        let unknowns = Unknowns { mobility: settings.mobility.clone(), com_axes: 2, root: false };
        let inverse = InverseKinematics::new(model, &planned, unknowns);
        let points: usize = soles.iter().map(|s| model.soles[s.0].vertices.len()).sum();
        PositionBalance {
            goal: planned.goal(),
            joints: inverse.joints().collect(),
            carrying: planned_robot::carrying_joints(model),
            efforts: vec![0.0; model.nj()],
            hull: Vec::with_capacity(3 * points + 2),
            edges: Vec::with_capacity(2 * points),
            started: 0.0,
            last_tick: 0.0,
            posture: model.home.clone(),
            reference: ReferenceTrajectory::new(1 + changes.len()),
            reads_zmp: leans(settings.leaning) || changes.iter().any(|c| c.leaning.is_some() && leans(c.leaning)),
            rise: settings.approach,
            times,
            changes,
            integral: Vector2::zeros(),
            damping: settings.damping.unwrap_or(0.0),
            leaning: settings.leaning.unwrap_or(0.0),
            settings,
            soles,
            planned,
            inverse,
            points: [PointOfInterest::named("balance.com"), PointOfInterest::named("balance.zmp")],
        }
    }

    /// Point of optimal stability of the plan, horizontal, world.
    fn find_reference(&mut self, context: &Context) -> Vector2<f64> {
        self.hull.clear();
        for sole in self.soles.iter().map(|s| &context.model.soles[s.0]) {
            self.hull.extend(sole.vertices.iter().map(|v| self.planned.ws.point(sole.link, v)));
        }
        convex_hull(&mut self.hull, &context.floor);
        let corners = self.hull.iter().map(|p| context.floor.flat(p));
        let found = stable_point(corners, &mut self.edges);
        found.map_or(self.planned.support().xy(), |f| context.floor.world(&f.point).xy())
    }

    /// Mean of the soles as sensed.
    fn sensed_support(&self, context: &Context) -> Vector2<f64> {
        let sum: Vector2<f64> = self.soles.iter().map(|s| context.data.soles[s.0].position.xy()).sum();
        sum / self.soles.len() as f64
    }

    /// Their mean height, m.
    fn ground(&self, context: &Context) -> f64 {
        self.soles.iter().map(|s| context.data.soles[s.0].position.z).sum::<f64>() / self.soles.len() as f64
    }
}

impl Task for PositionBalance {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        planned_robot::check_driven(context.model, command, &self.joints)?;
        self.planned.stand_as_commanded(context, command);
        self.goal = self.planned.goal();
        self.posture.copy_from_slice(&command.position);
        (self.started, self.last_tick) = (context.start, context.time);
        let height = (self.planned.com().z - self.planned.support().z).max(f64::MIN_POSITIVE);
        let rate = (context.gravity.norm() / height).sqrt();
        self.leaning = self.settings.leaning.unwrap_or((LEANING.0 * rate).min(LEANING.1));
        let slow = if rate > 0.0 { DAMPING.0 / (rate * rate) } else { 0.0 };
        self.damping = self.settings.damping.unwrap_or(slow.max(DAMPING.1));
        let support = self.planned.support().xy();
        let from = self.planned.com().xy() - support;
        self.reference.begin(from);
        let goal = self.find_reference(context) - support + self.settings.offset;
        self.reference.add(self.started, self.settings.approach, goal - from);
        self.integral = Vector2::zeros();
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let s = &self.settings;
        let t = context.time - self.started;
        let period = context.time - self.last_tick;
        self.last_tick = context.time;
        let progress = minimum_jerk(t, self.rise).0;
        let desired = self.reference.at(context.time).0;
        let here = self.sensed_support(context);
        let error = desired - (context.data.com.xy() - here);
        let load = context.data.zmp.map_or(Vector2::zeros(), |p| desired - (p.xy() - here));
        // While a sole stands on its edge the position of the load is unknown, and an integral over
        // it would be wrong once the sole is flat.
        let flat = self.soles.iter().all(|s| context.sensed.soles[s.0].clamped.iter().all(|c| *c));
        if flat {
            self.integral += (error * s.integral + load * self.leaning) * (period * progress);
        }
        self.integral = self.integral.map(|x| x.clamp(-s.reach, s.reach));
        let feedback = error * s.proportional - context.data.com_velocity.xy() * self.damping;
        let displacement = (self.integral + feedback * progress).map(|x| x.clamp(-s.reach, s.reach));
        let (com, ground) = (here + desired, self.ground(context));
        self.points[0].position = Some(Vector3::new(com.x, com.y, self.planned.com().z));
        self.points[1].position = Some(Vector3::new(com.x, com.y, ground));
        let planned = self.planned.support().xy() + desired + displacement;
        self.goal.com.x = planned.x;
        self.goal.com.y = planned.y;

        let (model, nb) = (context.model, context.model.nb());
        for (j, q) in self.planned.state.joints.iter_mut().enumerate() {
            if s.mobility[j] == 0.0 {
                *q = command.position[j];
            }
        }
        let back = (s.posture * period).min(1.0);
        for &j in &self.joints {
            self.inverse.preferred[nb + j] = back * (self.posture[j] - self.planned.state.joints[j]);
        }
        if period > 0.0 {
            self.inverse.advance(model, &mut self.planned, &self.goal, period);
        } else {
            self.planned.update(model);
        }
        // The velocity command stays zero: the plan's velocity contains the acceleration of the
        // centre of mass times k_d, which the servos' damping would close into a loop that is
        // unstable at the control rate.
        for &j in &self.joints {
            command.position[j] = self.planned.state.joints[j];
            command.velocity[j] = 0.0;
        }
        if s.feed_forward {
            let (still, com) = (Vector3::zeros(), self.planned.com().xy());
            let efforts = &mut self.efforts;
            feed_forward::efforts(model, &mut self.planned, &context.gravity, &still, &com, efforts);
            for &j in &self.carrying {
                command.effort[j] = (1.0 - progress) * command.effort[j] + progress * self.efforts[j];
            }
        }
        Ok(if has_elapsed(t, s.duration) { Status::Done } else { Status::Running })
    }

    fn change(&mut self, context: &Context, number: usize) -> TaskResult {
        let (change, s) = (&self.changes[number], &mut self.settings);
        s.proportional = change.proportional.unwrap_or(s.proportional);
        s.integral = change.integral.unwrap_or(s.integral);
        s.posture = change.posture.unwrap_or(s.posture);
        s.approach = change.approach.unwrap_or(s.approach);
        self.damping = change.damping.unwrap_or(self.damping);
        self.leaning = change.leaning.unwrap_or(self.leaning);
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
            self.reads_zmp |= newer.reads_zmp;
        }
    }

    fn changes(&self) -> &[f64] {
        &self.times
    }

    fn needs(&self) -> Needs {
        Needs::COM | Needs::SOLES | if self.reads_zmp { Needs::ZMP } else { Needs::LOADS }
    }

    fn is_temporary(&self) -> bool {
        true
    }

    fn points(&self) -> &[PointOfInterest] {
        &self.points
    }

    fn name(&self) -> &str {
        "balance"
    }
}
