//! The footstep plan: positions and times of the feet, and the zero-moment point between them.
//!
//! ```text
//! time    wait      step 1                step 2                      end
//! phase   both      both | swing foot 1   both | swing foot 2   ...   both
//!         S         d    | S - d          d    | S - d                d, then wait
//! ```
//!
//! with S the step time and d the time of double support. Footfall i (1 to n) of a walk with step
//! length L lands `i L` ahead of the initial position of the feet, the last one next to the other
//! foot at `(n - 1) L`; L = 0 steps in place. Heights follow in the same way, with a rise R for L: a
//! stair of treads L and R. The swinging foot moves along
//!
//! ```text
//! p(s) = p0 + (p1 - p0) (10 s^3 - 15 s^4 + 6 s^5),     z(s) = z0 + (z1 - z0) (same) + H 64 s^3 (1 - s)^3
//! ```
//!
//! which lifts off and lands without velocity or acceleration and is H above the floor at half the
//! swing. On stairs it moves across in the middle half of the swing, along the same quintic, and changes
//! its height in the first half on the way up, in the second on the way down: clear of the edge.
//!
//! The zero-moment point rests under the standing foot's centroid and moves across in double support
//! along the same quintic. The ground, above which the centre of mass has a constant height, is
//! that of the lower foot while both stand, whose leg is the longer one; it changes along the quintic
//! during the swing.

use crate::math;
use crate::motion::minimum_jerk::minimum_jerk;
use nalgebra::{Vector2, Vector3};

/// Parameters of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// Number of footfalls n.
    pub steps: usize,
    /// L, m; negative walks backwards.
    pub length: f64,
    /// R, m; negative walks down.
    pub rise: f64,
    /// S, s.
    pub time: f64,
    /// d, s; less than S.
    pub double_support: f64,
    /// H, m.
    pub height: f64,
    /// Time before the first step and after the last, s.
    pub wait: f64,
    /// Foot that swings first.
    pub first: usize,
}

/// One footfall.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Footfall {
    foot: usize,
    from: Vector3<f64>,
    to: Vector3<f64>,
}

/// The plan of a walk from two soles at given positions.
#[derive(Clone, Debug)]
pub struct Footsteps {
    stride: Stride,
    start: [Vector3<f64>; 2],
    /// Footfalls that begin before the end of the plan.
    footfalls: Vec<Footfall>,
}

impl Footsteps {
    /// A walk of soles with centroids at `start` (m) along the unit vector `ahead`, planned up to
    /// `until` seconds.
    pub fn new(stride: Stride, start: [Vector3<f64>; 2], ahead: Vector3<f64>, until: f64) -> Self {
        let mut positions = start;
        // The step in progress at the end and the one after it.
        let begun = ((until - stride.wait).max(0.0) / stride.time).ceil() as usize;
        let known = stride.steps.min(begun.saturating_add(2));
        let mut footfalls = Vec::with_capacity(known);
        for i in 1..=known {
            let foot = (stride.first + i - 1) % 2;
            let advance = if i == stride.steps { i - 1 } else { i };
            let (advance, up) = (advance as f64, Vector3::z());
            let to = start[foot] + ahead * (advance * stride.length) + up * (advance * stride.rise);
            footfalls.push(Footfall { foot, from: positions[foot], to });
            positions[foot] = to;
        }
        Footsteps { stride, start, footfalls }
    }

    /// Duration of the walk, s.
    pub fn duration(&self) -> f64 {
        2.0 * self.stride.wait + self.stride.steps as f64 * self.stride.time + self.stride.double_support
    }

    /// Step in progress at time `t` and the time since it began; `None` before the first and after
    /// the last.
    fn step(&self, t: f64) -> Option<(usize, f64)> {
        let since = t - self.stride.wait;
        let i = (since / self.stride.time).floor();
        (since >= 0.0 && i < self.footfalls.len() as f64).then_some((i as usize, since - i * self.stride.time))
    }

    /// Position (m) and velocity (m/s) of a sole's centroid.
    pub fn sole(&self, foot: usize, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (current, since) = match self.step(t) {
            Some((i, since)) => (i, since),
            None if t < self.stride.wait => return (self.start[foot], Vector3::zeros()),
            None => (self.footfalls.len(), 0.0),
        };
        if let Some(fall) = self.footfalls.get(current).filter(|f| f.foot == foot) {
            let (s, swing) = (since - self.stride.double_support, self.stride.time - self.stride.double_support);
            let middle = 0.5 * swing;
            let (progress, rate) =
                if self.stride.rise == 0.0 { minimum_jerk(s, swing) } else { minimum_jerk(s - 0.25 * swing, middle) };
            let (climb, climbing) = match self.stride.rise {
                0.0 => (progress, rate),
                rise if rise > 0.0 => minimum_jerk(s, middle),
                _ => minimum_jerk(s - middle, middle),
            };
            let u = (s / swing).clamp(0.0, 1.0);
            let lift = Vector3::z() * (self.stride.height * 64.0 * math::powi(u * (1.0 - u), 3));
            let rise = self.stride.height * 192.0 * math::powi(u * (1.0 - u), 2) * (1.0 - 2.0 * u) / swing;
            let shift = fall.to - fall.from;
            let part = |across: f64, up: f64| Vector3::new(shift.x * across, shift.y * across, shift.z * up);
            return (fall.from + part(progress, climb) + lift, part(rate, climbing) + Vector3::z() * rise);
        }
        let landed = self.footfalls[..current].iter().rev().find(|f| f.foot == foot);
        (landed.map_or(self.start[foot], |f| f.to), Vector3::zeros())
    }

    /// Landing position of a sole's centroid in the step in progress, or its present position, m.
    pub fn landing(&self, foot: usize, t: f64) -> Vector3<f64> {
        let begun = match self.step(t) {
            Some((i, _)) => i + 1,
            None if t < self.stride.wait => 0,
            None => self.footfalls.len(),
        };
        self.footfalls[..begun].iter().rev().find(|f| f.foot == foot).map_or(self.start[foot], |f| f.to)
    }

    /// Height of the ground above that at the start, m, its rate, m/s, and acceleration, m/s^2.
    pub fn ground(&self, t: f64) -> [f64; 3] {
        let before = |i: usize| {
            let foot = |foot: usize| {
                let landed = self.footfalls[..i].iter().rev().find(|f| f.foot == foot);
                landed.map_or(self.start[foot], |f| f.to).z
            };
            foot(0).min(foot(1))
        };
        let (i, since) = match self.step(t) {
            Some(step) => step,
            None if t < self.stride.wait => return [0.0; 3],
            None => return [before(self.footfalls.len()) - before(0), 0.0, 0.0],
        };
        let (from, rise) = (before(i) - before(0), before(i + 1) - before(i));
        let swing = self.stride.time - self.stride.double_support;
        let (progress, rate) = minimum_jerk(since - self.stride.double_support, swing);
        let s = ((since - self.stride.double_support) / swing).clamp(0.0, 1.0);
        let second = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (swing * swing);
        [from + rise * progress, rise * rate, rise * second]
    }

    /// Reference of the zero-moment point, m.
    pub fn zmp(&self, t: f64) -> Vector2<f64> {
        let both = |t: f64| (self.sole(0, t).0.xy() + self.sole(1, t).0.xy()) / 2.0;
        let start = |i: usize| self.stride.wait + i as f64 * self.stride.time;
        // Under the standing foot of step i; between the feet before the first and after the last.
        let target = |i: Option<usize>| match i.and_then(|i| Some((i, self.footfalls.get(i)?))) {
            Some((i, fall)) => self.sole(1 - fall.foot, start(i)).0.xy(),
            None if i == Some(self.footfalls.len()) => both(start(self.footfalls.len())),
            None => both(0.0),
        };
        let end = start(self.footfalls.len());
        let (current, since) = match self.step(t) {
            Some(step) => step,
            None if t < end => return target(None),
            None => (self.footfalls.len(), t - end),
        };
        let (from, to) = (target(current.checked_sub(1)), target(Some(current)));
        let progress =
            if self.stride.double_support > 0.0 { minimum_jerk(since, self.stride.double_support).0 } else { 1.0 };
        from + (to - from) * progress
    }
}
