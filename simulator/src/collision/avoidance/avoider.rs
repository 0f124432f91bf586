//! Converts the commands of the tasks into commands free of self-collision, tick by tick.

use std::sync::Arc;

use super::candidate::Robot;
use super::desired_motion::{DesiredMotion, PositionHistory};
use super::joint_path::JointPath;
use super::levers::Levers;
use super::methods::Methods;
use super::planner::{AT_GOAL, Planner, Settings};
use super::statistics::AvoidanceStatistics;
use super::tick_check::{DecayingOffset, JointMode, TickCheck};
use crate::collision::CollisionModel;
use crate::motion::spline::TrajectoryPoint;
use crate::robot::Model;

/// Longest time over which an acceleration is extrapolated, s.
const MAX_HORIZON: f64 = 0.1;

/// Time between cycles while a joint catches up with a motion that exceeds its limits, s.
const CATCH_UP: f64 = 0.01;

/// The joints at a tick, one entry per joint. Positions and velocities are commands, which are
/// replaced where they are not safe.
pub struct JointCommands<'a> {
    /// True for joints that follow their position command.
    pub follows: &'a [bool],
    /// Measured positions of the other joints.
    pub measured: &'a [f64],
    /// Their measured velocities.
    pub rates: &'a [f64],
    /// Positions.
    pub position: &'a mut [f64],
    /// Velocities.
    pub velocity: &'a mut [f64],
}

/// Keeps joint commands free of self-collision, see [`super`]. Does not allocate after
/// construction.
pub struct Avoider {
    collision: Arc<CollisionModel>,
    levers: Arc<Levers>,
    planner: Planner,
    methods: Methods,
    desired: DesiredMotion,
    /// Motion of the joints at the start of the cycle's paths.
    here: Vec<TrajectoryPoint>,
    tick_check: TickCheck,
    /// Commands of the last ticks.
    commanded: PositionHistory,
    /// Paths of the joints that are not free.
    paths: Vec<JointPath>,
    /// Joints that may not follow the desired motion.
    refused: Vec<bool>,
    /// Time of the last tick, s.
    last: f64,
    /// Number of the next regular cycle.
    next: u64,
    /// Time of the last cycle, s.
    last_cycle: f64,
    /// Work and effect since the start.
    pub statistics: AvoidanceStatistics,
}

impl Avoider {
    /// For a robot commanded to hold `start` at time `begin`, with ticks every `period` seconds.
    pub fn new(
        model: &Model,
        collision: Arc<CollisionModel>,
        settings: Settings,
        start: &[f64],
        (begin, period): (f64, f64),
    ) -> Self {
        let levers = Arc::new(Levers::new(model, &collision));
        let robot = Robot { model, collision: &collision, levers: &levers, margin: settings.margin };
        let n = start.len();
        Avoider {
            methods: Methods::new(settings.seed, n, collision.pairs.len()),
            planner: Planner::new(settings, robot, start, begin),
            desired: DesiredMotion::new(start, period),
            here: vec![TrajectoryPoint::default(); n],
            tick_check: TickCheck::new(n),
            commanded: PositionHistory::new(start, period),
            paths: start.iter().map(|&q| JointPath::resting(q)).collect(),
            refused: vec![false; n],
            last: begin - period,
            next: 0,
            last_cycle: f64::NEG_INFINITY,
            statistics: AvoidanceStatistics::default(),
            collision,
            levers,
        }
    }

    /// For each joint: whether a method keeps it from its desired position.
    pub fn stopped(&self) -> &[bool] {
        &self.planner.stopped
    }

    /// Desired position of a joint at the last tick, within its range.
    pub fn desired(&self, joint: usize) -> f64 {
        self.desired.now(joint).q
    }

    /// One tick at time `now`: replaces the desired `commands` by safe ones.
    pub fn tick(&mut self, model: &Model, now: f64, commands: &mut JointCommands) {
        self.planner.now = now;
        let changes = self.update_modes(commands);
        let (rate, limits) = (self.planner.settings.rate, &self.planner.settings.limits);
        self.desired.push(commands.position, commands.velocity, limits);
        let due = now >= self.next as f64 / rate - 1e-9;
        if due {
            self.next = (now * rate + 1e-6).floor() as u64 + 1;
        }
        // A joint that its limits hold back catches up sooner when its goal is updated more often.
        let late = self.tick_check.late.contains(&true) && now >= self.last_cycle + CATCH_UP - 1e-9;
        if due || changes || late || !self.tick_is_safe(model) {
            self.last_cycle = now;
            self.statistics.early += u64::from(!due);
            self.cycle(model, commands, due);
        }
        self.last = now;
        for j in (0..commands.follows.len()).filter(|j| commands.follows[*j]) {
            let desired = self.desired.now(j);
            let mut out = self.command_at(j, now);
            if self.tick_check.mode[j] == JointMode::Free && commands.position[j] == desired.q {
                // The velocity command is not changed, whether or not it fits the positions.
                out.v += commands.velocity[j] - desired.v;
            }
            (commands.position[j], commands.velocity[j]) = (out.q, out.v);
            let off = (out.q - desired.q).abs();
            let statistics = &mut self.statistics;
            statistics.ticks += 1;
            statistics.held_back += u64::from(self.planner.stopped[j] || off > AT_GOAL);
            statistics.squares += off * off;
            statistics.greatest = statistics.greatest.max(off);
        }
        self.commanded.next().copy_from_slice(commands.position);
    }

    /// Updates which joints follow their commands. A joint that begins to follow continues from its
    /// measured motion. Returns whether a joint has changed.
    fn update_modes(&mut self, commands: &JointCommands) -> bool {
        let mut changes = false;
        for j in 0..commands.follows.len() {
            match (commands.follows[j], self.tick_check.mode[j]) {
                (false, mode) => {
                    changes |= mode != JointMode::Uncontrolled;
                    self.tick_check.mode[j] = JointMode::Uncontrolled;
                    self.paths[j] = JointPath::resting(commands.measured[j]);
                }
                (true, JointMode::Uncontrolled) => {
                    let here = TrajectoryPoint { q: commands.measured[j], v: commands.rates[j], a: 0.0 };
                    self.paths[j] = JointPath::stop(here, self.planner.now, &self.planner.settings.limits[j]);
                    self.tick_check.mode[j] = JointMode::OnPath;
                    changes = true;
                }
                _ => {}
            }
        }
        changes
    }

    fn command_at(&self, j: usize, t: f64) -> TrajectoryPoint {
        match self.tick_check.mode[j] {
            JointMode::Free => self.tick_check.command(j, &self.desired.now(j), t),
            _ => self.paths[j].at(t),
        }
    }

    fn tick_is_safe(&mut self, model: &Model) -> bool {
        let Settings { margin, limits, .. } = &self.planner.settings;
        let robot = Robot { model, collision: &self.collision, levers: &self.levers, margin: *margin };
        let refused = (self.planner.now, self.refused.as_mut_slice());
        let motion = (&self.desired, &self.commanded);
        self.tick_check.allows(robot, &self.planner.candidate, motion, &self.paths, limits, refused)
    }

    /// Plans new paths of the joints, from their state at the last tick.
    fn cycle(&mut self, model: &Model, commands: &JointCommands, due: bool) {
        let before = self.planner.candidate.detector.counts.postures;
        self.predict(commands);
        let (collision, levers) = (self.collision.clone(), self.levers.clone());
        let margin = self.planner.settings.margin;
        let robot = Robot { model, collision: &collision, levers: &levers, margin };
        self.planner.candidate.measure(robot);
        if self.planner.candidate.uncontrolled.contains(&true) {
            self.planner.candidate.brake(robot, &self.here, &self.planner.settings.limits);
            self.propose_goals(commands);
        }
        let free = self.methods.decide(&mut self.planner, robot);
        self.adopt(robot, due);
        while !self.tick_is_safe(model) && self.refused.contains(&true) {
            for j in 0..self.refused.len() {
                if self.refused[j] && self.tick_check.mode[j] == JointMode::Free {
                    self.tick_check.mode[j] = JointMode::OnPath;
                }
            }
        }
        let tests = self.planner.candidate.detector.counts.postures - before;
        let statistics = &mut self.statistics;
        statistics.cycles += 1;
        statistics.blocked += u64::from(!free);
        statistics.tests += tests;
        (statistics.tests_last, statistics.tests_max) = (tests, statistics.tests_max.max(tests));
    }

    /// Sets the joints' present motion, their fallback paths, and the paths to the goals.
    fn predict(&mut self, commands: &JointCommands) {
        let Planner { candidate, settings, .. } = &mut self.planner;
        let (begin, period) = (self.last, 1.0 / settings.rate);
        candidate.begin = begin;
        for (j, limits) in settings.limits.iter().enumerate() {
            candidate.uncontrolled[j] = self.tick_check.mode[j] == JointMode::Uncontrolled;
            let fallback = match self.tick_check.mode[j] {
                JointMode::Free => self.tick_check.stop(j, &self.desired.before(j), begin, limits),
                JointMode::OnPath => self.paths[j],
                JointMode::Uncontrolled => JointPath::drift(commands.measured[j], commands.rates[j], begin, period),
            };
            self.here[j] = fallback.at(begin);
            candidate.anchor[j] = self.here[j].q;
            candidate.fallback[j] = fallback;
            candidate.reset(j);
        }
        self.propose_goals(commands);
    }

    /// Proposes the soonest paths to the desired motion one cycle ahead that keep the limits.
    fn propose_goals(&mut self, commands: &JointCommands) {
        let planner = &mut self.planner;
        let (begin, period) = (self.last, 1.0 / planner.settings.rate);
        let horizon = period.min(MAX_HORIZON);
        planner.stopped.fill(false);
        for (j, limits) in planner.settings.limits.iter().enumerate() {
            planner.proposed[j] = planner.candidate.fallback[j];
            if !commands.follows[j] {
                continue;
            }
            planner.goal[j] = self.desired.ahead(j, period, horizon, limits).q;
            let (here, shortest) = (self.here[j], planner.now - begin + period);
            let path = JointPath::soonest(here, begin, shortest, limits, |duration| {
                self.desired.ahead(j, begin + duration - planner.now, horizon, limits)
            });
            match path {
                Some(path) => {
                    planner.proposed[j] = path;
                    planner.candidate.set(j, path);
                }
                None => planner.stopped[j] = (planner.goal[j] - here.q).abs() > AT_GOAL,
            }
        }
    }

    /// Lets the joints follow the candidate, free where that is safe. Only regular cycles free a
    /// joint: until then a refused joint stays on its path.
    fn adopt(&mut self, robot: Robot, due: bool) {
        let planner = &self.planner;
        let (candidate, period) = (&planner.candidate, 1.0 / planner.settings.rate);
        let check = &mut self.tick_check;
        for (j, limits) in planner.settings.limits.iter().enumerate() {
            let path = candidate.paths[j];
            let previous = check.mode[j];
            if previous == JointMode::Uncontrolled {
                continue;
            }
            self.paths[j] = path;
            check.mode[j] = JointMode::OnPath;
            let may_free = due || check.late[j];
            if planner.stopped[j] || path != planner.proposed[j] || (previous == JointMode::OnPath && !may_free) {
                continue;
            }
            let (here, desired) = (path.at(candidate.begin), self.desired.before(j));
            let offset = match previous {
                JointMode::Free => Some(check.offset[j]),
                _ => DecayingOffset::new(&here, &desired, candidate.begin, period, limits),
            };
            if let Some(offset) = offset {
                check.mode[j] = JointMode::Free;
                check.offset[j] = offset;
                check.late[j] = false;
            }
        }
        for pair in 0..self.collision.pairs.len() {
            if candidate.is_clear(robot, pair) {
                continue;
            }
            for lever in robot.levers.of(pair) {
                if check.mode[lever.joint] == JointMode::Free {
                    check.mode[lever.joint] = JointMode::OnPath;
                }
            }
        }
    }
}
