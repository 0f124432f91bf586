//! Monitors self-collision of the robot and modifies commands to avoid it.
//!
//! A lower bound on the distance of the nearest pair of bodies avoids most tests. With d the
//! distance at the posture c of the last test, and L_k the greatest lever of joint k in any pair,
//! no pair is nearer than
//!
//! ```text
//! d - sum over k of L_k |q_k - c_k|
//! ```
//!
//! While that is above the margin and above the smallest distance so far, no test is needed.

use std::sync::Arc;

use super::report::{AvoidanceTime, Metrics, SelfContactSnapshot};
use super::setup::Setup;
use crate::collision::avoidance::{self, Avoider, JointCommands, Settings};
use crate::collision::{CollisionModel, Detector, LinkPose, link_poses};
use crate::dynamics::{State, Workspace};
use crate::robot::{DriveMode, Model};
use crate::task::Command;
use cpu_time::ThreadTime;

/// Self-collision of a run.
#[derive(Clone)]
pub struct SelfCollisionSetup {
    /// Bodies and pairs.
    pub collision: Arc<CollisionModel>,
    /// Distance that counts as near, m.
    pub margin: f64,
    /// How collisions are avoided; none: they are only reported.
    pub avoid: Option<Settings>,
}

/// Distances, collisions and avoidance of a run.
pub struct SelfCollisionMonitor {
    collision: Arc<CollisionModel>,
    detector: Detector,
    poses: Vec<LinkPose>,
    margin: f64,
    avoider: Option<Avoider>,
    /// Measured joint positions and velocities.
    measured: (Vec<f64>, Vec<f64>),
    /// For each joint: does it follow commanded positions?
    follows: Vec<bool>,
    /// Greatest lever of each joint, m/rad or 1.
    levers: Vec<f64>,
    /// Posture of the last test, and its least distance, m.
    tested: Vec<f64>,
    least: f64,
    /// Time of the last check, s.
    checked_at: f64,
    /// For each pair: do its bodies overlap?
    touching: Vec<bool>,
    /// Least distance of the run, m.
    smallest: f64,
    /// Time with a distance below the margin, s.
    near: f64,
    /// Overlaps that began.
    collisions: u64,
    avoidance_time: AvoidanceTime,
}

impl SelfCollisionMonitor {
    /// Prepares the monitor of a run that starts at `state`, if `setup` has one. Avoidance needs a
    /// control tick in every period.
    pub fn of_run(setup: &mut Setup, state: &State) -> Option<Box<Self>> {
        let collision = setup.self_collision.take()?;
        if collision.avoid.is_some() {
            setup.tasks.tick_always();
        }
        let (command, period) = (&setup.tasks.command, setup.tasks.period());
        Some(Box::new(SelfCollisionMonitor::new(collision, &setup.model, command, state, period)))
    }

    /// Prepares a monitor; `period` is that of the control ticks, s.
    fn new(setup: SelfCollisionSetup, model: &Model, command: &Command, state: &State, period: f64) -> Self {
        let SelfCollisionSetup { collision, margin, avoid } = setup;
        let nj = model.nj();
        let start = (state.time, period);
        SelfCollisionMonitor {
            detector: Detector::new(&collision),
            poses: vec![LinkPose::IDENTITY; model.links.len()],
            margin,
            avoider: avoid.map(|a| Avoider::new(model, collision.clone(), a, &command.position, start)),
            measured: (vec![0.0; nj], vec![0.0; nj]),
            follows: vec![true; nj],
            levers: avoidance::levers(model, &collision),
            tested: vec![f64::NAN; nj],
            least: f64::NEG_INFINITY,
            checked_at: state.time,
            touching: vec![false; collision.pairs.len()],
            smallest: f64::INFINITY,
            near: 0.0,
            collisions: 0,
            avoidance_time: AvoidanceTime { total_s: 0.0, cycles_s: 0.0 },
            collision,
        }
    }

    /// Modifies joint commands to avoid self-collision, if configured.
    pub fn avoid(&mut self, model: &Model, state: &State, command: &mut Command) {
        let Some(avoider) = &mut self.avoider else { return };
        let clock = ThreadTime::try_now().ok();
        self.measured.0.copy_from_slice(&state.joints);
        self.measured.1.copy_from_slice(&state.v[model.nb()..]);
        for (follows, mode) in self.follows.iter_mut().zip(&command.mode) {
            *follows = matches!(mode, DriveMode::Position | DriveMode::Kinematic);
        }
        let mut commands = JointCommands {
            follows: &self.follows,
            measured: &self.measured.0,
            rates: &self.measured.1,
            position: &mut command.position,
            velocity: &mut command.velocity,
        };
        let cycles = avoider.statistics.cycles;
        avoider.tick(model, state.time, &mut commands);
        // NaN on systems without a clock per thread.
        let spent = clock.and_then(|c| c.try_elapsed().ok()).map_or(f64::NAN, |d| d.as_secs_f64());
        self.avoidance_time.total_s += spent;
        if avoider.statistics.cycles > cycles {
            self.avoidance_time.cycles_s += spent;
        }
    }

    /// Checks a posture. Calls `report` for each pair whose overlap begins or ends.
    pub fn check(&mut self, model: &Model, state: &State, mut report: impl FnMut(&str, usize, &CollisionModel)) {
        let elapsed = state.time - self.checked_at;
        self.checked_at = state.time;
        let moved: f64 =
            self.levers.iter().zip(&self.tested).zip(&state.joints).map(|((l, a), b)| l * (a - b).abs()).sum();
        if self.least - moved > self.smallest.max(self.margin) {
            return;
        }
        let distance = self.test(model, &state.joints);
        self.smallest = self.smallest.min(distance);
        if distance < self.margin {
            self.near += elapsed;
        }
        if distance > 0.0 && !self.touching.contains(&true) {
            return;
        }
        let overlapping = self.detector.colliding(&self.collision, 0.0);
        for (pair, touching) in self.touching.iter_mut().enumerate() {
            let now = overlapping.binary_search(&pair).is_ok();
            if now != *touching {
                report(if now { "begins" } else { "ends" }, pair, &self.collision);
                self.collisions += u64::from(now);
                *touching = now;
            }
        }
    }

    /// Least distance in a posture, m; infinite without pairs.
    fn test(&mut self, model: &Model, q: &[f64]) -> f64 {
        link_poses(model, q, &mut self.poses);
        self.detector.set_poses(&self.collision, &self.poses);
        self.tested.copy_from_slice(q);
        self.least = self.detector.closest(&self.collision, f64::INFINITY).map_or(f64::INFINITY, |p| p.distance);
        self.least
    }

    /// Fills a snapshot with the posture of `ws`.
    pub fn fill(&mut self, model: &Model, state: &State, ws: &Workspace, out: &mut SelfContactSnapshot) {
        link_poses(model, &state.joints, &mut self.poses);
        self.detector.set_poses(&self.collision, &self.poses);
        let nearest = self.detector.closest(&self.collision, f64::INFINITY);
        let world = |p| ws.links[0].rotation * p + ws.links[0].origin + ws.position;
        out.nearest = nearest.map(|p| (p.distance, p.pair, world(p.on_a), world(p.on_b)));
        if let Some(avoider) = &self.avoider {
            (out.cycles, out.tests) = (avoider.statistics.cycles, avoider.statistics.tests_last);
            out.frozen.copy_from_slice(avoider.stopped());
            out.desired.iter_mut().enumerate().for_each(|(j, w)| *w = avoider.desired(j));
        }
    }

    /// A snapshot with all vectors allocated.
    pub fn blank(&self) -> SelfContactSnapshot {
        let name = |pair: &crate::collision::Pair| pair.bodies.map(|b| self.collision.bodies[b].name.clone());
        let joints = if self.avoider.is_some() { self.levers.len() } else { 0 };
        SelfContactSnapshot {
            pairs: self.collision.pairs.iter().map(name).collect(),
            frozen: vec![false; joints],
            desired: vec![0.0; joints],
            ..SelfContactSnapshot::default()
        }
    }

    /// Writes the measurements into the metrics.
    pub fn write_metrics(&self, m: &mut Metrics) {
        m.min_self_distance_m = Some(self.smallest).filter(|d| d.is_finite());
        m.self_collisions = Some(self.collisions);
        m.self_near_s = Some(self.near);
        let Some(statistics) = self.avoider.as_ref().map(|a| &a.statistics) else { return };
        m.avoidance_cycles = Some(statistics.cycles);
        m.avoidance_early_cycles = Some(statistics.early);
        m.avoidance_blocked_cycles = Some(statistics.blocked);
        m.avoidance_tests_mean = statistics.tests_mean();
        m.avoidance_tests_max = Some(statistics.tests_max);
        m.avoidance_held_share = statistics.held_share();
        m.avoidance_rms_deviation = statistics.deviation();
        m.avoidance_max_deviation = Some(statistics.greatest);
    }

    /// Processor time of avoidance, if configured.
    pub fn avoidance_time(&self) -> Option<AvoidanceTime> {
        self.avoider.is_some().then_some(self.avoidance_time)
    }
}
