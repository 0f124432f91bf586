//! Time profile of a push: a factor between 0 and 1.
//!
//! With `s = (t - start) / duration`: `constant` 1, `half-sine` sin(pi s), `triangle` 1 - |2 s -
//! 1|, each zero outside 0 <= s < 1; `ramp` rises as s and stays at 1.

use crate::math;

/// Shape over time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Shape {
    /// 1 between start and end.
    Constant,
    /// Half a period of a sine.
    HalfSine,
    /// Linear rise and fall.
    Triangle,
    /// Linear rise, then 1.
    Ramp,
    /// 1 at all times.
    Always,
}

/// A shape with its time span.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    shape: Shape,
    start: f64,
    duration: f64,
    corners: Vec<f64>,
}

impl Profile {
    /// A shape from `start` for `duration` seconds; the duration may be infinite for `Constant`.
    pub fn new(shape: Shape, start: f64, duration: f64) -> Self {
        let end = start + duration;
        let corners = match shape {
            Shape::Always => vec![],
            Shape::Triangle => vec![start, start + 0.5 * duration, end],
            _ => vec![start, end],
        };
        Profile { shape, start, duration, corners: corners.into_iter().filter(|c| c.is_finite()).collect() }
    }

    /// Times at which the value or slope is discontinuous, s.
    pub fn corners(&self) -> &[f64] {
        &self.corners
    }

    /// The factor at `time`, on the smooth piece that contains `within`.
    pub fn factor(&self, time: f64, within: f64) -> f64 {
        let s = (time - self.start) / self.duration;
        let piece = (within - self.start) / self.duration;
        match self.shape {
            Shape::Always => 1.0,
            _ if within < self.start => 0.0,
            Shape::Ramp if piece < 1.0 => s,
            Shape::Ramp => 1.0,
            _ if piece >= 1.0 => 0.0,
            Shape::Constant => 1.0,
            Shape::HalfSine => math::sin(std::f64::consts::PI * s),
            Shape::Triangle if piece < 0.5 => 2.0 * s,
            Shape::Triangle => 2.0 - 2.0 * s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impulses_are_the_closed_forms() {
        // Integral of the factor over its duration (midpoint rule, error of order h^2): 1, 2/pi,
        // 1/2, 1/2.
        for (shape, area) in [
            (Shape::Constant, 1.0),
            (Shape::HalfSine, 2.0 / std::f64::consts::PI),
            (Shape::Triangle, 0.5),
            (Shape::Ramp, 0.5),
        ] {
            let p = Profile::new(shape, 2.0, 0.1);
            let n = 10_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let t = 2.0 + 0.1 * (i as f64 + 0.5) / n as f64;
                    p.factor(t, t)
                })
                .sum();
            assert!((sum / n as f64 - area).abs() < 1e-8, "{shape:?}");
            assert_eq!(p.factor(1.9, 1.9), 0.0);
            assert_eq!(p.factor(2.2, 2.2), if shape == Shape::Ramp { 1.0 } else { 0.0 });
        }
    }

    #[test]
    fn a_jump_belongs_to_the_piece_being_integrated() {
        let p = Profile::new(Shape::Constant, 1.0, 1.0);
        assert_eq!((p.factor(1.0, 0.9), p.factor(1.0, 1.1)), (0.0, 1.0));
        assert_eq!((p.factor(2.0, 1.9), p.factor(2.0, 2.1)), (1.0, 0.0));
    }
}
