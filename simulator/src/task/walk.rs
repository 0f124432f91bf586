//! `walk`: follows a footstep plan, with the centre of mass under preview control of the
//! zero-moment point.
//!
//! Feet and zero-moment-point reference come from [`super::gait::footsteps`], the horizontal motion
//! of the centre of mass from [`super::gait::preview`], planned to the end of walk or run when the
//! task begins. Its height above the lower foot is constant between swings and the root stays upright.
//! [`super::kinematic`] gives the joint positions at every tick.

use super::gait::{Footsteps, Preview, Sample, Stride};
use super::kinematic::{PlannedRobot, PosturePlanner};
use super::{Command, Context, PointOfInterest, Status, Task, TaskError, TaskResult, has_elapsed};
use crate::dynamics::Motion;
use crate::motion::minimum_jerk::minimum_jerk;
use crate::robot::Model;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// Sampling period of the pattern, s; between its samples the motion is exact.
pub const PERIOD: f64 = 0.005;
/// Preview horizon of the zero-moment point, s [Kajita 2003].
const HORIZON: f64 = 1.6;
/// Greatest tilt of soles and gravity at the start, rad.
const LEVEL: f64 = 0.02;

/// Task that walks.
pub struct Walk {
    stride: Stride,
    /// Height of the centre of mass above the soles, m; none: as at the start.
    height: Option<f64>,
    /// Time to move to the starting posture, s.
    settle: f64,
    feed_forward: bool,
    /// Time from the start of the task to the end of the run, s: the plan ends there.
    until: f64,
    planner: PosturePlanner,
    start: f64,
    over: Vector3<f64>,
    upright: UnitQuaternion<f64>,
    plan: Option<Plan>,
    /// Planned centre of mass and zero-moment point, then the present or next position of each
    /// sole.
    points: [PointOfInterest; 4],
}

/// The plan made at the start of the task.
struct Plan {
    footsteps: Footsteps,
    /// Samples of x and of y of the centre of mass.
    samples: [Vec<Sample>; 2],
    /// Height of the soles at the start, m.
    ground: f64,
    /// Height of the centre of mass over gravity, s^2.
    lag: f64,
}

impl Plan {
    /// Horizontal position, velocity and acceleration of the centre of mass.
    fn com(&self, t: f64) -> [Vector3<f64>; 2] {
        self.samples.each_ref().map(|axis| {
            let k = ((t / PERIOD).floor().max(0.0) as usize).min(axis.len() - 1);
            axis[k].at((t - k as f64 * PERIOD).clamp(0.0, PERIOD))
        })
    }
}

impl Walk {
    /// For a robot that [`super::kinematic::planned_robot::check_biped`] accepts, in a run that
    /// ends `until` seconds after the task's start.
    pub fn new(
        model: &Model,
        stride: Stride,
        height: Option<f64>,
        settle: f64,
        feed_forward: bool,
        until: f64,
    ) -> Self {
        Walk {
            stride,
            height,
            settle,
            feed_forward,
            until,
            planner: PosturePlanner::new(model),
            start: 0.0,
            over: Vector3::zeros(),
            upright: UnitQuaternion::identity(),
            plan: None,
            points: [
                PointOfInterest::named("walk.com"),
                PointOfInterest::named("walk.zmp"),
                PointOfInterest::named(format!("walk.foot.{}", model.soles[0].name)),
                PointOfInterest::named(format!("walk.foot.{}", model.soles[1].name)),
            ],
        }
    }
}

impl Task for Walk {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.planner.begin(context, command)?;
        self.start = context.start;
        let planned = &self.planner.planned;
        self.upright = PlannedRobot::upright(&planned.state.rotation);
        let lean = |s: usize| planned.normal(context.model, s).map_or(0.0, |n| n.angle(&Vector3::z()));
        if let Some(s) = (0..2).find(|&s| lean(s) > LEVEL) {
            let sole = context.model.soles[s].name.clone();
            return Err(TaskError::TiltedSole { sole, angle: lean(s) });
        }
        let down = context.gravity.angle(&-Vector3::z());
        if down > LEVEL {
            return Err(TaskError::TiltedGravity { angle: down });
        }
        let soles = [0, 1].map(|s| planned.sole(s).translation.vector);
        let support = planned.support();
        let height = self.height.unwrap_or(planned.com().z - support.z);
        self.over = Vector3::new(support.x, support.y, support.z + height);
        let gravity = context.gravity.norm();
        let preview = Preview::new(height, gravity, PERIOD, HORIZON)
            .filter(|_| gravity > 0.0 && height > 0.0)
            .ok_or(TaskError::NoGait { height, gravity })?;
        // Beyond the end of the run only the preview horizon is planned.
        let needed = (self.until - self.settle).max(0.0);
        let footsteps = Footsteps::new(self.stride, soles, self.upright * Vector3::x(), needed + HORIZON + PERIOD);
        let samples = |time: f64| (time.min(footsteps.duration()) / PERIOD).ceil() as usize + 1;
        let (count, previewed) = (samples(needed), samples(needed + HORIZON));
        let reference =
            |axis: usize| -> Vec<f64> { (0..previewed).map(|k| footsteps.zmp(k as f64 * PERIOD)[axis]).collect() };
        let samples = [0, 1].map(|axis| preview.follow(&reference(axis), count));
        self.plan = Some(Plan { footsteps, samples, ground: support.z, lag: preview.lag });
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let Some(plan) = &self.plan else { return Ok(Status::Done) };
        let t = context.time - self.start;
        self.planner.approach(t, self.settle, self.over, self.upright);
        let since = t - self.settle;
        let done = has_elapsed(since, plan.footsteps.duration());
        let (mut acceleration, mut zmp, mut ground) = (Vector3::zeros(), self.over.xy(), plan.ground);
        if since > 0.0 {
            let [x, y] = plan.com(since);
            let z = plan.footsteps.ground(since);
            ground += z[0];
            self.planner.goal.com = Vector3::new(x[0], y[0], self.over.z + z[0]);
            let moving = if done { 0.0 } else { 1.0 };
            self.planner.rates.com = Vector3::new(x[1], y[1], z[1]) * moving;
            acceleration = Vector3::new(x[2], y[2], z[2]) * moving;
            zmp = Vector2::new(x[0], y[0]) - acceleration.xy() * plan.lag;
            for s in 0..2 {
                let (position, velocity) = plan.footsteps.sole(s, since);
                self.planner.goal.soles[s].translation.vector = position;
                self.planner.rates.soles[s] = Motion::new(velocity, Vector3::zeros());
            }
        }
        let reference = plan.footsteps.zmp(since.max(0.0));
        let feet = [0, 1].map(|s| plan.footsteps.landing(s, since));
        let positions = [self.planner.goal.com, Vector3::new(reference.x, reference.y, ground), feet[0], feet[1]];
        self.points.iter_mut().zip(positions).for_each(|(point, at)| point.position = Some(at));
        self.planner.write_joints(context, command)?;
        if self.feed_forward {
            let part = minimum_jerk(t, self.settle).0;
            self.planner.add_feed_forward(context, command, &acceleration, &zmp, part);
        }
        Ok(if done { Status::Done } else { Status::Running })
    }

    fn is_temporary(&self) -> bool {
        true
    }

    fn points(&self) -> &[PointOfInterest] {
        &self.points
    }

    fn name(&self) -> &str {
        "walk"
    }
}
