//! `squat`: the centre of mass moves down and up over the middle of the soles, which stay in place.
//!
//! ```text
//! h(t) = h0 - D f(2 u)           0 <= u < 1/2       f(s) = 10 s^3 - 15 s^4 + 6 s^5
//! h(t) = h0 - D (1 - f(2 u - 1)) 1/2 <= u < 1       u = t / T modulo 1
//! ```
//!
//! with D the depth and T the period. First the centre of mass moves over the middle of the soles
//! and the root turns upright. [`super::kinematic`] gives the joint positions.

use super::kinematic::{PlannedRobot, PosturePlanner};
use super::{Command, Context, PointOfInterest, Status, Task, TaskResult, has_elapsed};
use crate::motion::minimum_jerk::minimum_jerk;
use crate::robot::Model;
use nalgebra::{UnitQuaternion, Vector3};

/// Parameters of a squat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// D, m; negative: rises first.
    pub depth: f64,
    /// T, s.
    pub period: f64,
    /// Number of periods.
    pub repetitions: u32,
    /// Time of the initial move over the soles, s.
    pub settle: f64,
}

impl Shape {
    /// Descent of the centre of mass from its start (m), its upward velocity (m/s) and acceleration
    /// (m/s^2), `t` seconds after settling.
    pub fn drop(&self, t: f64) -> (f64, f64, f64) {
        let half = 0.5 * self.period;
        let end = f64::from(self.repetitions) * self.period;
        if t <= 0.0 || t >= end {
            return (0.0, 0.0, 0.0);
        }
        let since = t % self.period;
        let (progress, rate) = minimum_jerk(since % half, half);
        let s = since % half / half;
        let bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (half * half);
        if since < half {
            (self.depth * progress, -self.depth * rate, -self.depth * bend)
        } else {
            (self.depth * (1.0 - progress), self.depth * rate, self.depth * bend)
        }
    }

    /// Total time with settling, s.
    pub fn duration(&self) -> f64 {
        self.settle + f64::from(self.repetitions) * self.period
    }
}

/// Task that squats.
pub struct Squat {
    shape: Shape,
    planner: PosturePlanner,
    feed_forward: bool,
    start: f64,
    over: Vector3<f64>,
    upright: UnitQuaternion<f64>,
    /// The planned centre of mass.
    points: [PointOfInterest; 1],
}

impl Squat {
    /// For a robot that [`super::kinematic::planned_robot::check`] accepts.
    pub fn new(model: &Model, shape: Shape, feed_forward: bool) -> Self {
        let planner = PosturePlanner::new(model);
        let points = [PointOfInterest::named("squat.com")];
        let (over, upright) = (Vector3::zeros(), UnitQuaternion::identity());
        Squat { shape, planner, feed_forward, start: 0.0, over, upright, points }
    }
}

impl Task for Squat {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.planner.begin(context, command)?;
        self.start = context.start;
        let planned = &self.planner.planned;
        let support = planned.support();
        self.over = Vector3::new(support.x, support.y, planned.com().z);
        self.upright = PlannedRobot::upright(&planned.state.rotation);
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let t = context.time - self.start;
        self.planner.approach(t, self.shape.settle, self.over, self.upright);
        let (drop, rate, bend) = self.shape.drop(t - self.shape.settle);
        self.planner.goal.com.z -= drop;
        self.planner.rates.com.z += rate;
        self.points[0].position = Some(self.planner.goal.com);
        self.planner.write_joints(context, command)?;
        if self.feed_forward {
            let part = minimum_jerk(t, self.shape.settle).0;
            self.planner.add_feed_forward(context, command, &Vector3::new(0.0, 0.0, bend), &self.over.xy(), part);
        }
        Ok(if has_elapsed(t, self.shape.duration()) { Status::Done } else { Status::Running })
    }

    fn is_temporary(&self) -> bool {
        true
    }

    fn points(&self) -> &[PointOfInterest] {
        &self.points
    }

    fn name(&self) -> &str {
        "squat"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drop_has_its_closed_form() {
        let shape = Shape { depth: 0.03, period: 2.0, repetitions: 2, settle: 0.5 };
        // Half the depth at a quarter of the period, all of it at half, with the peak rate 15/8 of
        // the mean between.
        for (t, truth) in [(0.0, 0.0), (0.5, 0.015), (1.0, 0.03), (1.5, 0.015), (2.0, 0.0), (3.0, 0.03), (4.0, 0.0)] {
            assert!((shape.drop(t).0 - truth).abs() < 1e-15, "{t}");
        }
        assert!((shape.drop(0.5).1 + 0.03 * 15.0 / 8.0).abs() < 1e-15);
        assert!((shape.drop(3.5).1 - 0.03 * 15.0 / 8.0).abs() < 1e-15);
        assert_eq!(shape.drop(4.1), (0.0, 0.0, 0.0));
        // Rates are derivatives: central differences of step 1e-5, whose error is h^2 times the
        // third derivative, about 1e-10.
        for t in [0.2, 0.7, 1.3, 1.9] {
            let (a, b) = (shape.drop(t - 1e-5), shape.drop(t + 1e-5));
            assert!((shape.drop(t).1 + (b.0 - a.0) / 2e-5).abs() < 1e-8);
            assert!((shape.drop(t).2 - (b.1 - a.1) / 2e-5).abs() < 1e-8);
        }
        assert_eq!(shape.duration(), 4.5);
    }
}
