//! From what the tasks want to what the drives are asked, tick by tick.

use std::sync::Arc;

use super::around::Detour;
use super::bound::Levers;
use super::guard::{Fading, Guard, Way};
use super::path::Path;
use super::tally::Tally;
use super::trial::{Robot, Trial};
use super::wanted::{Ring, Wanted};
use super::{Limits, methods};
use crate::collision::CollisionModel;
use crate::motion::spline::Point;
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
pub struct Asked<'a> {
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
    pub(super) trial: Trial,
    pub(super) wanted: Wanted,
    pub(super) detour: Detour,
    pub(super) random: Stream,
    /// Joints that the method at hand keeps from where the tasks want them.
    pub(super) frozen: Vec<bool>,
    /// Pairs for which joints were frozen.
    pub(super) culprits: Vec<usize>,
    /// Where the tasks want the joints, one cycle ahead.
    pub(super) goal: Vec<f64>,
    /// Paths to there; where none keeps the limits, what the joint does otherwise.
    pub(super) proposed: Vec<Path>,
    /// Scratch of the methods: paths, a posture, joints.
    pub(super) best: Vec<Path>,
    pub(super) onward: Vec<Path>,
    pub(super) posture: Vec<f64>,
    pub(super) marked: Vec<bool>,
    /// Motion of the joints at the beginning of the cycle's paths.
    here: Vec<Point>,
    /// Time of the tick at hand, s.
    pub(super) now: f64,
    guard: Guard,
    /// What was asked at the last ticks.
    asked: Ring,
    /// Of the joints that are not free.
    paths: Vec<Path>,
    refused: Vec<bool>,
    /// Time of the last tick, s.
    last: f64,
    next: u64,
    /// Time of the last cycle, s.
    decided: f64,
    /// What was done.
    pub tally: Tally,
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
        let resting: Vec<Path> = start.iter().map(|&q| Path::resting(q)).collect();
        let n = start.len();
        Avoider {
            trial: Trial::new(robot, start),
            wanted: Wanted::new(start, period),
            detour: Detour::new(n),
            random: Stream::new(settings.seed, &["self-collision"]),
            frozen: vec![false; n],
            culprits: Vec::with_capacity(2 * collision.pairs.len()),
            here: vec![Point::default(); n],
            goal: start.to_vec(),
            proposed: resting.clone(),
            best: resting.clone(),
            onward: resting.clone(),
            posture: start.to_vec(),
            marked: vec![false; n],
            now: begin,
            guard: Guard::new(n),
            asked: Ring::new(start, period),
            paths: resting,
            refused: vec![false; n],
            last: begin - period,
            next: 0,
            decided: f64::NEG_INFINITY,
            tally: Tally::default(),
            collision,
            levers,
            settings,
        }
    }

    /// Is a joint kept from where the tasks want it?
    pub fn frozen(&self) -> &[bool] {
        &self.frozen
    }

    /// Where the tasks wanted a joint at the last tick, within its range.
    pub fn wanted(&self, joint: usize) -> f64 {
        self.wanted.now(joint).q
    }

    /// One tick at time `now`: `asked` comes as the tasks want it and goes as it is safe.
    pub fn tick(&mut self, model: &Model, now: f64, asked: &mut Asked) {
        self.now = now;
        let changes = self.take_hold(asked);
        self.wanted.push(asked.position, asked.velocity, &self.settings.limits);
        let due = now >= self.next as f64 / self.settings.rate - 1e-9;
        if due {
            self.next = (now * self.settings.rate + 1e-6).floor() as u64 + 1;
        }
        // A joint that its limits have left behind finds its way sooner when it is asked more often where it leads.
        let late = self.guard.late.contains(&true) && now >= self.decided + HURRY - 1e-9;
        if due || changes || late || !self.guard_allows(model) {
            self.decided = now;
            self.tally.early += u64::from(!due);
            self.cycle(model, asked, due);
        }
        self.last = now;
        for j in (0..asked.follows.len()).filter(|j| asked.follows[*j]) {
            let wanted = self.wanted.now(j);
            let mut out = self.out(j, now);
            if self.guard.way[j] == Way::Free && asked.position[j] == wanted.q {
                // As it was told, whether or not it fits the positions.
                out.v += asked.velocity[j] - wanted.v;
            }
            (asked.position[j], asked.velocity[j]) = (out.q, out.v);
            let off = (out.q - wanted.q).abs();
            let tally = &mut self.tally;
            tally.ticks += 1;
            tally.held_back += u64::from(self.frozen[j] || off > methods::AT_GOAL);
            tally.squares += off * off;
            tally.greatest = tally.greatest.max(off);
        }
        self.asked.next().copy_from_slice(asked.position);
    }

    /// Takes note of which joints follow their commands. One that begins to goes on from where and how it is measured to move;
    /// true when there is one.
    fn take_hold(&mut self, asked: &Asked) -> bool {
        let mut changes = false;
        for j in 0..asked.follows.len() {
            match (asked.follows[j], self.guard.way[j]) {
                (false, way) => {
                    changes |= way != Way::Loose;
                    self.guard.way[j] = Way::Loose;
                    self.paths[j] = Path::resting(asked.measured[j]);
                }
                (true, Way::Loose) => {
                    let here = Point { q: asked.measured[j], v: asked.rates[j], a: 0.0 };
                    self.paths[j] = Path::stop(here, self.now, &self.settings.limits[j]);
                    self.guard.way[j] = Way::Held;
                    changes = true;
                }
                _ => {}
            }
        }
        changes
    }

    fn out(&self, j: usize, t: f64) -> Point {
        match self.guard.way[j] {
            Way::Free => self.guard.asked(j, &self.wanted.now(j), t),
            _ => self.paths[j].at(t),
        }
    }

    fn guard_allows(&mut self, model: &Model) -> bool {
        let robot = Robot { model, collision: &self.collision, levers: &self.levers, margin: self.settings.margin };
        let limits = &self.settings.limits;
        let refused = (self.now, self.refused.as_mut_slice());
        self.guard.allows(robot, &self.trial, (&self.wanted, &self.asked), &self.paths, limits, refused)
    }

    /// Decides anew where the joints go, from where they were at the last tick.
    fn cycle(&mut self, model: &Model, asked: &Asked, due: bool) {
        let before = self.trial.detector.counts.postures;
        self.look_ahead(asked);
        let collision = self.collision.clone();
        // Levers are only read, and by this cycle alone.
        let levers = std::mem::take(&mut self.levers);
        let robot = Robot { model, collision: &collision, levers: &levers, margin: self.settings.margin };
        self.trial.measure(robot);
        if self.trial.loose.contains(&true) {
            self.trial.brake(robot, &self.here, &self.settings.limits);
            self.propose(asked);
        }
        let free = methods::decide(self, robot);
        self.adopt(robot, due);
        self.levers = levers;
        while !self.guard_allows(model) && self.refused.contains(&true) {
            for j in 0..self.refused.len() {
                if self.refused[j] && self.guard.way[j] == Way::Free {
                    self.guard.way[j] = Way::Held;
                }
            }
        }
        let tests = self.trial.detector.counts.postures - before;
        let tally = &mut self.tally;
        tally.cycles += 1;
        tally.blocked += u64::from(!free);
        tally.tests += tests;
        (tally.tests_last, tally.tests_max) = (tests, tally.tests_max.max(tests));
    }

    /// Where the joints are, what they do otherwise, and the paths to where the tasks want them.
    fn look_ahead(&mut self, asked: &Asked) {
        let (begin, period) = (self.last, 1.0 / self.settings.rate);
        self.trial.begin = begin;
        for (j, limits) in self.settings.limits.iter().enumerate() {
            self.trial.loose[j] = self.guard.way[j] == Way::Loose;
            let otherwise = match self.guard.way[j] {
                Way::Free => self.guard.stop(j, &self.wanted.before(j), begin, limits),
                Way::Held => self.paths[j],
                Way::Loose => Path::drift(asked.measured[j], asked.rates[j], begin, period),
            };
            self.here[j] = otherwise.at(begin);
            self.trial.anchor[j] = self.here[j].q;
            self.trial.otherwise[j] = otherwise;
            self.trial.reset(j);
        }
        self.propose(asked);
    }

    /// Lets the trial lead where the tasks want the joints.
    fn propose(&mut self, asked: &Asked) {
        let (begin, period) = (self.last, 1.0 / self.settings.rate);
        self.frozen.fill(false);
        for (j, limits) in self.settings.limits.iter().enumerate() {
            self.proposed[j] = self.trial.otherwise[j];
            if !asked.follows[j] {
                continue;
            }
            self.goal[j] = self.wanted.ahead(j, period, period.min(FARTHEST), limits).q;
            match self.way_to_wanted(j, self.here[j], begin, period) {
                Some(path) => {
                    self.proposed[j] = path;
                    self.trial.set(j, path);
                }
                None => self.frozen[j] = (self.goal[j] - self.here[j].q).abs() > methods::AT_GOAL,
            }
        }
    }

    /// The soonest path to where the tasks want a joint that keeps the limits.
    fn way_to_wanted(&self, j: usize, here: Point, begin: f64, period: f64) -> Option<Path> {
        let limits = &self.settings.limits[j];
        methods::soonest(here, begin, self.now - begin + period, limits, |duration| {
            self.wanted.ahead(j, begin + duration - self.now, period.min(FARTHEST), limits)
        })
    }

    /// Lets the joints follow the paths of the trial, free where they may be. Only regular cycles set a joint free: between
    /// them one that was refused stays on its path.
    fn adopt(&mut self, robot: Robot, due: bool) {
        let period = 1.0 / self.settings.rate;
        for (j, limits) in self.settings.limits.iter().enumerate() {
            let path = self.trial.paths[j];
            let was = self.guard.way[j];
            if was == Way::Loose {
                continue;
            }
            self.paths[j] = path;
            self.guard.way[j] = Way::Held;
            let may = due || self.guard.late[j];
            if self.frozen[j] || path != self.proposed[j] || (was == Way::Held && !may) {
                continue;
            }
            let (here, wanted) = (path.at(self.trial.begin), self.wanted.before(j));
            let fade = match was {
                Way::Free => Some(self.guard.fade[j]),
                _ => Fading::new(&here, &wanted, self.trial.begin, period, limits),
            };
            if let Some(fade) = fade {
                self.guard.way[j] = Way::Free;
                self.guard.fade[j] = fade;
                self.guard.late[j] = false;
            }
        }
        for pair in 0..self.collision.pairs.len() {
            if self.trial.is_clear(robot, pair) {
                continue;
            }
            for lever in robot.levers.of(pair) {
                if self.guard.way[lever.joint] == Way::Free {
                    self.guard.way[lever.joint] = Way::Held;
                }
            }
        }
    }
}
