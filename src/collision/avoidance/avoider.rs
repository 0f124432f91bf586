//! From what the tasks want to what the drives are asked, tick by tick.

use std::sync::Arc;

use super::candidate::{CandidatePaths, Robot};
use super::desired_motion::{DesiredMotion, PositionHistory};
use super::detour::Detour;
use super::joint_path::JointPath;
use super::levers::Levers;
use super::statistics::AvoidanceStatistics;
use super::tick_check::{DecayingOffset, JointMode, TickCheck};
use super::{Limits, methods};
use crate::collision::CollisionModel;
use crate::motion::spline::TrajectoryPoint;
use crate::random::Stream;
use crate::robot::Model;

/// Longest time for which an acceleration is taken to last, s.
const FARTHEST: f64 = 0.1;

/// Time between cycles while a joint catches up with a motion that its limits do not allow, s.
const HURRY: f64 = 0.01;

/// How collisions are avoided.
#[derive(Clone, Debug)]
pub struct Settings {
    /// 1 to 4 as in the paper's Table I.
    pub method: u8,
    /// Cycles per second.
    pub rate: f64,
    /// Distance that is kept, m.
    pub margin: f64,
    /// By joint.
    pub limits: Vec<Limits>,
    /// Of random perturbations.
    pub seed: u64,
}

/// What the joints are asked at a tick, before and after; one entry per joint.
pub struct JointCommands<'a> {
    /// Does the joint follow its position?
    pub follows: &'a [bool],
    /// Measured positions, of those that do not.
    pub measured: &'a [f64],
    /// Their measured velocities.
    pub rates: &'a [f64],
    /// Positions.
    pub position: &'a mut [f64],
    /// Velocities.
    pub velocity: &'a mut [f64],
}

/// See [`super`]. Allocates nothing after construction.
pub struct Avoider {
    pub(super) collision: Arc<CollisionModel>,
    pub(super) levers: Levers,
    pub(super) settings: Settings,
    pub(super) candidate: CandidatePaths,
    pub(super) wanted: DesiredMotion,
    pub(super) detour: Detour,
    pub(super) random: Stream,
    /// Joints that the method at hand keeps from where the tasks want them.
    pub(super) stopped: Vec<bool>,
    /// Pairs for which joints were stopped.
    pub(super) blocking: Vec<usize>,
    /// Where the tasks want the joints, one cycle ahead.
    pub(super) goal: Vec<f64>,
    /// Paths to there; where none keeps the limits, what the joint does fallback.
    pub(super) proposed: Vec<JointPath>,
    /// Scratch of the methods: paths, a posture, joints.
    pub(super) best: Vec<JointPath>,
    pub(super) continuation: Vec<JointPath>,
    pub(super) posture: Vec<f64>,
    pub(super) marked: Vec<bool>,
    /// Motion of the joints at the beginning of the cycle's paths.
    here: Vec<TrajectoryPoint>,
    /// Time of the tick at hand, s.
    pub(super) now: f64,
    tick_check: TickCheck,
    /// What was asked at the last ticks.
    asked: PositionHistory,
    /// Of the joints that are not free.
    paths: Vec<JointPath>,
    refused: Vec<bool>,
    /// Time of the last tick, s.
    last: f64,
    next: u64,
    /// Time of the last cycle, s.
    last_cycle: f64,
    /// What was done.
    pub statistics: AvoidanceStatistics,
}

impl Avoider {
    /// For a robot that is asked to hold `start` at first, with `period` seconds from tick to tick.
    pub fn new(
        model: &Model,
        collision: Arc<CollisionModel>,
        settings: Settings,
        start: &[f64],
        (begin, period): (f64, f64),
    ) -> Self {
        let levers = Levers::new(model, &collision);
        let robot = Robot { model, collision: &collision, levers: &levers, margin: settings.margin };
        let resting: Vec<JointPath> = start.iter().map(|&q| JointPath::resting(q)).collect();
        let n = start.len();
        Avoider {
            candidate: CandidatePaths::new(robot, start),
            wanted: DesiredMotion::new(start, period),
            detour: Detour::new(n),
            random: Stream::new(settings.seed, &["self-collision"]),
            stopped: vec![false; n],
            blocking: Vec::with_capacity(2 * collision.pairs.len()),
            here: vec![TrajectoryPoint::default(); n],
            goal: start.to_vec(),
            proposed: resting.clone(),
            best: resting.clone(),
            continuation: resting.clone(),
            posture: start.to_vec(),
            marked: vec![false; n],
            now: begin,
            tick_check: TickCheck::new(n),
            asked: PositionHistory::new(start, period),
            paths: resting,
            refused: vec![false; n],
            last: begin - period,
            next: 0,
            last_cycle: f64::NEG_INFINITY,
            statistics: AvoidanceStatistics::default(),
            collision,
            levers,
            settings,
        }
    }

    /// Is a joint kept from where the tasks want it?
    pub fn stopped(&self) -> &[bool] {
        &self.stopped
    }

    /// Where the tasks wanted a joint at the last tick, within its range.
    pub fn wanted(&self, joint: usize) -> f64 {
        self.wanted.now(joint).q
    }

    /// One tick at time `now`: `asked` comes as the tasks want it and goes as it is safe.
    pub fn tick(&mut self, model: &Model, now: f64, asked: &mut JointCommands) {
        self.now = now;
        let changes = self.update_modes(asked);
        self.wanted.push(asked.position, asked.velocity, &self.settings.limits);
        let due = now >= self.next as f64 / self.settings.rate - 1e-9;
        if due {
            self.next = (now * self.settings.rate + 1e-6).floor() as u64 + 1;
        }
        // A joint that its limits have left behind finds its way sooner when it is asked more often where it leads.
        let late = self.tick_check.late.contains(&true) && now >= self.last_cycle + HURRY - 1e-9;
        if due || changes || late || !self.tick_is_safe(model) {
            self.last_cycle = now;
            self.statistics.early += u64::from(!due);
            self.cycle(model, asked, due);
        }
        self.last = now;
        for j in (0..asked.follows.len()).filter(|j| asked.follows[*j]) {
            let wanted = self.wanted.now(j);
            let mut out = self.out(j, now);
            if self.tick_check.mode[j] == JointMode::Free && asked.position[j] == wanted.q {
                // As it was told, whether or not it fits the positions.
                out.v += asked.velocity[j] - wanted.v;
            }
            (asked.position[j], asked.velocity[j]) = (out.q, out.v);
            let off = (out.q - wanted.q).abs();
            let statistics = &mut self.statistics;
            statistics.ticks += 1;
            statistics.held_back += u64::from(self.stopped[j] || off > methods::AT_GOAL);
            statistics.squares += off * off;
            statistics.greatest = statistics.greatest.max(off);
        }
        self.asked.next().copy_from_slice(asked.position);
    }

    /// Takes note of which joints follow their commands. One that begins to goes on from where and how it is measured to move;
    /// true when there is one.
    fn update_modes(&mut self, asked: &JointCommands) -> bool {
        let mut changes = false;
        for j in 0..asked.follows.len() {
            match (asked.follows[j], self.tick_check.mode[j]) {
                (false, way) => {
                    changes |= way != JointMode::Uncontrolled;
                    self.tick_check.mode[j] = JointMode::Uncontrolled;
                    self.paths[j] = JointPath::resting(asked.measured[j]);
                }
                (true, JointMode::Uncontrolled) => {
                    let here = TrajectoryPoint { q: asked.measured[j], v: asked.rates[j], a: 0.0 };
                    self.paths[j] = JointPath::stop(here, self.now, &self.settings.limits[j]);
                    self.tick_check.mode[j] = JointMode::OnPath;
                    changes = true;
                }
                _ => {}
            }
        }
        changes
    }

    fn out(&self, j: usize, t: f64) -> TrajectoryPoint {
        match self.tick_check.mode[j] {
            JointMode::Free => self.tick_check.asked(j, &self.wanted.now(j), t),
            _ => self.paths[j].at(t),
        }
    }

    fn tick_is_safe(&mut self, model: &Model) -> bool {
        let robot = Robot { model, collision: &self.collision, levers: &self.levers, margin: self.settings.margin };
        let limits = &self.settings.limits;
        let refused = (self.now, self.refused.as_mut_slice());
        self.tick_check.allows(robot, &self.candidate, (&self.wanted, &self.asked), &self.paths, limits, refused)
    }

    /// Decides anew where the joints go, from where they were at the last tick.
    fn cycle(&mut self, model: &Model, asked: &JointCommands, due: bool) {
        let before = self.candidate.detector.counts.postures;
        self.predict(asked);
        let collision = self.collision.clone();
        // Levers are only read, and by this cycle alone.
        let levers = std::mem::take(&mut self.levers);
        let robot = Robot { model, collision: &collision, levers: &levers, margin: self.settings.margin };
        self.candidate.measure(robot);
        if self.candidate.uncontrolled.contains(&true) {
            self.candidate.brake(robot, &self.here, &self.settings.limits);
            self.propose_goals(asked);
        }
        let free = methods::decide(self, robot);
        self.adopt(robot, due);
        self.levers = levers;
        while !self.tick_is_safe(model) && self.refused.contains(&true) {
            for j in 0..self.refused.len() {
                if self.refused[j] && self.tick_check.mode[j] == JointMode::Free {
                    self.tick_check.mode[j] = JointMode::OnPath;
                }
            }
        }
        let tests = self.candidate.detector.counts.postures - before;
        let statistics = &mut self.statistics;
        statistics.cycles += 1;
        statistics.blocked += u64::from(!free);
        statistics.tests += tests;
        (statistics.tests_last, statistics.tests_max) = (tests, statistics.tests_max.max(tests));
    }

    /// Where the joints are, what they do fallback, and the paths to where the tasks want them.
    fn predict(&mut self, asked: &JointCommands) {
        let (begin, period) = (self.last, 1.0 / self.settings.rate);
        self.candidate.begin = begin;
        for (j, limits) in self.settings.limits.iter().enumerate() {
            self.candidate.uncontrolled[j] = self.tick_check.mode[j] == JointMode::Uncontrolled;
            let fallback = match self.tick_check.mode[j] {
                JointMode::Free => self.tick_check.stop(j, &self.wanted.before(j), begin, limits),
                JointMode::OnPath => self.paths[j],
                JointMode::Uncontrolled => JointPath::drift(asked.measured[j], asked.rates[j], begin, period),
            };
            self.here[j] = fallback.at(begin);
            self.candidate.anchor[j] = self.here[j].q;
            self.candidate.fallback[j] = fallback;
            self.candidate.reset(j);
        }
        self.propose_goals(asked);
    }

    /// Lets the candidate lead where the tasks want the joints.
    fn propose_goals(&mut self, asked: &JointCommands) {
        let (begin, period) = (self.last, 1.0 / self.settings.rate);
        self.stopped.fill(false);
        for (j, limits) in self.settings.limits.iter().enumerate() {
            self.proposed[j] = self.candidate.fallback[j];
            if !asked.follows[j] {
                continue;
            }
            self.goal[j] = self.wanted.ahead(j, period, period.min(FARTHEST), limits).q;
            match self.path_to_desired(j, self.here[j], begin, period) {
                Some(path) => {
                    self.proposed[j] = path;
                    self.candidate.set(j, path);
                }
                None => self.stopped[j] = (self.goal[j] - self.here[j].q).abs() > methods::AT_GOAL,
            }
        }
    }

    /// The soonest path to where the tasks want a joint that keeps the limits.
    fn path_to_desired(&self, j: usize, here: TrajectoryPoint, begin: f64, period: f64) -> Option<JointPath> {
        let limits = &self.settings.limits[j];
        methods::soonest(here, begin, self.now - begin + period, limits, |duration| {
            self.wanted.ahead(j, begin + duration - self.now, period.min(FARTHEST), limits)
        })
    }

    /// Lets the joints follow the paths of the candidate, free where they may be. Only regular cycles set a joint free: between
    /// them one that was refused stays on its path.
    fn adopt(&mut self, robot: Robot, due: bool) {
        let period = 1.0 / self.settings.rate;
        for (j, limits) in self.settings.limits.iter().enumerate() {
            let path = self.candidate.paths[j];
            let was = self.tick_check.mode[j];
            if was == JointMode::Uncontrolled {
                continue;
            }
            self.paths[j] = path;
            self.tick_check.mode[j] = JointMode::OnPath;
            let may = due || self.tick_check.late[j];
            if self.stopped[j] || path != self.proposed[j] || (was == JointMode::OnPath && !may) {
                continue;
            }
            let (here, wanted) = (path.at(self.candidate.begin), self.wanted.before(j));
            let offset = match was {
                JointMode::Free => Some(self.tick_check.offset[j]),
                _ => DecayingOffset::new(&here, &wanted, self.candidate.begin, period, limits),
            };
            if let Some(offset) = offset {
                self.tick_check.mode[j] = JointMode::Free;
                self.tick_check.offset[j] = offset;
                self.tick_check.late[j] = false;
            }
        }
        for pair in 0..self.collision.pairs.len() {
            if self.candidate.is_clear(robot, pair) {
                continue;
            }
            for lever in robot.levers.of(pair) {
                if self.tick_check.mode[lever.joint] == JointMode::Free {
                    self.tick_check.mode[lever.joint] = JointMode::OnPath;
                }
            }
        }
    }
}
