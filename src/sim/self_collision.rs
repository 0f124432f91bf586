//! Monitors self-collision of the robot and makes commands safe from it.
//!
//! A lower bound on the distance of the nearest pair of bodies avoids most tests: with d at the posture c of the last
//! test, and L_k the greatest lever of joint k in any pair, no pair is nearer than
//!
//! ```text
//! d - sum over k of L_k |q_k - c_k|
//! ```
//!
//! While that is above the margin and above the smallest distance so far, no test is needed.

use std::sync::Arc;

use super::report::{AvoidanceTime, Metrics, SelfContactSnapshot};
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
    /// Measured joint motion, of joints that follow no positions.
    measured: (Vec<f64>, Vec<f64>),
    follows: Vec<bool>,
    /// Greatest lever of each joint, m/rad or 1.
    levers: Vec<f64>,
    /// Posture of the last test, and its least distance.
    tested: Vec<f64>,
    least: f64,
    /// Time of the last check, s.
    checked: f64,
    touching: Vec<bool>,
    smallest: f64,
    near: f64,
    collisions: u64,
    /// Processor time of avoidance.
    spent: AvoidanceTime,
}

impl SelfCollisionMonitor {
    /// Prepares the monitor of a run; `period` is that of the control ticks, s.
    pub fn new(setup: SelfCollisionSetup, model: &Model, command: &Command, state: &State, period: f64) -> Self {
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
            checked: state.time,
            touching: vec![false; collision.pairs.len()],
            smallest: f64::INFINITY,
            near: 0.0,
            collisions: 0,
            spent: AvoidanceTime { total_s: 0.0, cycles_s: 0.0 },
            collision,
        }
    }

    /// Makes joint commands safe.
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
        self.spent.total_s += spent;
        if avoider.statistics.cycles > cycles {
            self.spent.cycles_s += spent;
        }
    }

    /// Checks a posture; calls `report` for pairs that begin or end to overlap.
    pub fn check(&mut self, model: &Model, state: &State, mut report: impl FnMut(&str, usize, &CollisionModel)) {
        let passed = state.time - self.checked;
        self.checked = state.time;
        let moved: f64 =
            self.levers.iter().zip(&self.tested).zip(&state.joints).map(|((l, a), b)| l * (a - b).abs()).sum();
        if self.least - moved > self.smallest.max(self.margin) {
            return;
        }
        let distance = self.test(model, &state.joints);
        self.smallest = self.smallest.min(distance);
        if distance < self.margin {
            self.near += passed;
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
            out.wanted.iter_mut().enumerate().for_each(|(j, w)| *w = avoider.desired(j));
        }
    }

    /// A snapshot with all vectors allocated.
    pub fn blank(&self) -> SelfContactSnapshot {
        let name = |pair: &crate::collision::Pair| pair.bodies.map(|b| self.collision.bodies[b].name.clone());
        let joints = if self.avoider.is_some() { self.levers.len() } else { 0 };
        SelfContactSnapshot {
            pairs: self.collision.pairs.iter().map(name).collect(),
            frozen: vec![false; joints],
            wanted: vec![0.0; joints],
            ..SelfContactSnapshot::default()
        }
    }

    /// Writes the measurements into the metrics.
    pub fn write(&self, m: &mut Metrics) {
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
    pub fn spent(&self) -> Option<AvoidanceTime> {
        self.avoider.is_some().then_some(self.spent)
    }
}
