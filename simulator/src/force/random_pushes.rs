//! `random-pushes`: pushes with times, links, directions and magnitudes drawn before the run.
//!
//! With a given number of pushes, their instants are independent and uniform over the span. With a
//! rate r they form a Poisson process with gaps `-ln(u) / r`. Magnitudes and durations are uniform
//! between their limits; all links are equally likely. A direction is uniform over the circle, or
//! over the sphere: z uniform between -1 and 1 and the angle about it uniform (Archimedes).

use super::profile::{Profile, Shape};
use super::wrench::Wrench;
use super::{AppliedForces, Force, ForceContext, ReportEvent};
use crate::math;
use crate::random::Stream;
use crate::robot::LinkId;
use nalgebra::Vector3;
use std::any::Any;

/// Distributions from which pushes are drawn.
#[derive(Clone, Debug)]
pub struct Distribution {
    /// Earliest start, s.
    pub start: f64,
    /// Length of the interval of starts, s.
    pub span: f64,
    /// Number of pushes.
    pub count: Count,
    /// Links with their names and the points pushed, in their internal frames, m.
    pub targets: Vec<(String, LinkId, Vector3<f64>)>,
    /// Least and greatest force, N.
    pub magnitude: [f64; 2],
    /// Shortest and longest push, s.
    pub duration: [f64; 2],
    /// True for horizontal directions, false for all.
    pub horizontal: bool,
    /// Profile of each push.
    pub shape: Shape,
}

/// Number of pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Count {
    /// A fixed number.
    Number(usize),
    /// Mean number per second, Hz.
    Rate(f64),
}

#[derive(Clone, Debug)]
struct Push {
    at: f64,
    end: f64,
    name: String,
    wrench: Wrench,
    /// True once it is reported, or was over when this model took effect.
    reported: bool,
}

/// A series of random pushes.
#[derive(Clone, Debug)]
pub struct RandomPushes {
    /// In order of their starts.
    pushes: Vec<Push>,
    longest: f64,
    corners: Vec<f64>,
    /// Number of pushes that have begun and are reported.
    reported: usize,
}

/// Greatest number of pushes of one entry.
pub const MAX_PUSHES: usize = 10_000;

impl RandomPushes {
    /// Draws the pushes, at most [`MAX_PUSHES`].
    pub fn draw(from: &Distribution, stream: &mut Stream) -> Self {
        let pushes: Vec<Push> = draw_starts(from, stream).into_iter().map(|at| from.draw_push(at, stream)).collect();
        let corners = pushes.iter().flat_map(|p| p.wrench.profile.corners().iter().copied()).collect();
        RandomPushes { pushes, longest: from.duration[1], corners, reported: 0 }
    }
}

/// Starts of the pushes, ascending.
fn draw_starts(from: &Distribution, stream: &mut Stream) -> Vec<f64> {
    match from.count {
        Count::Number(n) => {
            let mut at: Vec<f64> = (0..n.min(MAX_PUSHES)).map(|_| from.start + from.span * stream.unit()).collect();
            at.sort_by(f64::total_cmp);
            at
        }
        Count::Rate(rate) => {
            let mut at = from.start;
            let next = || {
                at -= math::ln(stream.unit()) / rate;
                (at < from.start + from.span).then_some(at)
            };
            std::iter::from_fn(next).take(MAX_PUSHES).collect()
        }
    }
}

impl Distribution {
    fn draw_push(&self, at: f64, stream: &mut Stream) -> Push {
        let (name, link, point) = &self.targets[stream.below(self.targets.len() as u64) as usize];
        let mut between = |[a, b]: [f64; 2]| a + (b - a) * stream.unit();
        let (magnitude, duration) = (between(self.magnitude), between(self.duration));
        let up = if self.horizontal { 0.0 } else { between([-1.0, 1.0]) };
        let (sin, cos) = math::sin_cos(between([0.0, std::f64::consts::TAU]));
        let flat = (1.0 - up * up).sqrt();
        let wrench = Wrench {
            link: *link,
            point: *point,
            force: Vector3::new(flat * cos, flat * sin, up) * magnitude,
            moment: Vector3::zeros(),
            axes: None,
            profile: Profile::new(self.shape, at, duration),
        };
        Push { at, end: at + duration, name: name.clone(), wrench, reported: false }
    }
}

impl Force for RandomPushes {
    fn continue_from(&mut self, former: &dyn Any, time: f64) {
        let Some(former) = former.downcast_ref::<RandomPushes>() else { return };
        let known = &former.pushes[..former.reported];
        for push in &mut self.pushes {
            push.reported = push.end <= time || known.iter().any(|other| other.at == push.at);
        }
    }

    fn arrows(&self) -> usize {
        let overlapping = |i: usize| {
            let since = self.pushes[i].at;
            let earlier = self.pushes[..=i].iter().rev().take_while(|p| p.at + self.longest >= since);
            earlier.filter(|p| p.end > since).count()
        };
        (0..self.pushes.len()).map(overlapping).max().unwrap_or(0)
    }

    fn on_corner(&mut self, context: &ForceContext, report: &mut ReportEvent) {
        while let Some(push) = self.pushes.get_mut(self.reported).filter(|p| p.at <= context.time) {
            if !std::mem::replace(&mut push.reported, true) {
                let [x, y, z] = push.wrench.force.into();
                report("push", &push.name, format!("({x:.3}, {y:.3}, {z:.3}) N for {:.4} s", push.end - push.at));
            }
            self.reported += 1;
        }
    }

    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        // Pushes that have begun, latest first, back to where even the longest has ended.
        let begun = self.pushes.partition_point(|p| p.at <= context.within);
        for push in self.pushes[..begun].iter_mut().rev() {
            if push.at + self.longest < context.within {
                break;
            }
            push.wrench.evaluate(context, applied);
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distribution(count: Count, horizontal: bool) -> Distribution {
        let targets = ["a", "b", "c"].iter().enumerate();
        Distribution {
            start: 2.0,
            span: 8.0,
            count,
            targets: targets.map(|(i, name)| (name.to_string(), LinkId(i), Vector3::zeros())).collect(),
            magnitude: [5.0, 20.0],
            duration: [0.1, 0.3],
            horizontal,
            shape: Shape::HalfSine,
        }
    }

    #[test]
    fn draws_have_their_distributions() {
        let n = 4000;
        let from = distribution(Count::Number(n), false);
        let drawn = RandomPushes::draw(&from, &mut Stream::new(7, &["force", "0"]));
        assert_eq!(drawn.pushes.len(), n);
        assert!(drawn.pushes.windows(2).all(|w| w[0].at <= w[1].at), "in order");
        // Five standard deviations of the mean of n uniform numbers: range / sqrt(12 n) each.
        let five = |range: f64| 5.0 * range / (12.0 * n as f64).sqrt();
        let mean = |f: &dyn Fn(&Push) -> f64| drawn.pushes.iter().map(f).sum::<f64>() / n as f64;
        assert!((mean(&|p| p.at) - 6.0).abs() < five(8.0));
        assert!((mean(&|p| p.wrench.force.norm()) - 12.5).abs() < five(15.0));
        assert!((mean(&|p| p.end - p.at) - 0.2).abs() < five(0.2));
        for axis in 0..3 {
            // Each coordinate of a uniform direction is uniform between -1 and 1.
            assert!(mean(&|p| p.wrench.force.normalize()[axis]).abs() < five(2.0), "{axis}");
            let square = mean(&|p| p.wrench.force.normalize()[axis].powi(2));
            // Squares have mean 1/3 and deviation sqrt(4/45).
            assert!((square - 1.0 / 3.0).abs() < 5.0 * (4.0 / 45.0 / n as f64).sqrt(), "{axis}: {square}");
        }
        for link in 0..3 {
            let share = mean(&|p| f64::from(u8::from(p.wrench.link.0 == link)));
            assert!((share - 1.0 / 3.0).abs() < 5.0 * (2.0 / 9.0 / n as f64).sqrt(), "{share}");
        }
        let flat = RandomPushes::draw(&distribution(Count::Number(9), true), &mut Stream::new(7, &["force", "0"]));
        assert!(flat.pushes.iter().all(|p| p.wrench.force.z == 0.0));
    }

    #[test]
    fn a_rate_gives_a_poisson_process() {
        let (rate, runs) = (25.0, 100);
        let counts: Vec<f64> = (0..runs)
            .map(|seed| {
                let drawn =
                    RandomPushes::draw(&distribution(Count::Rate(rate), true), &mut Stream::new(seed, &["force"]));
                assert!(drawn.pushes.iter().all(|p| (2.0..10.0).contains(&p.at)));
                drawn.pushes.len() as f64
            })
            .collect();
        let mean = counts.iter().sum::<f64>() / runs as f64;
        let variance = counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (runs - 1) as f64;
        // Mean and variance are both 200. The standard deviations of their estimates are
        // sqrt(200 / 100) and 200 sqrt(2 / 99).
        assert!((mean - 200.0).abs() < 5.0 * 2.0_f64.sqrt(), "{mean}");
        assert!((variance - 200.0).abs() < 5.0 * 200.0 * (2.0 / 99.0_f64).sqrt(), "{variance}");
    }

    #[test]
    fn draws_depend_on_the_seed_alone() {
        let drawn = |seed| {
            let pushes =
                RandomPushes::draw(&distribution(Count::Number(5), true), &mut Stream::new(seed, &["f"])).pushes;
            pushes.iter().map(|p| (p.at, p.wrench.force, p.wrench.link)).collect::<Vec<_>>()
        };
        assert_eq!(drawn(3), drawn(3));
        assert_ne!(drawn(3), drawn(4));
    }
}
