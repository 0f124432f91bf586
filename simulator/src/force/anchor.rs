//! The anchor of a spring: a point that rests, drifts, oscillates or follows waypoints.
//!
//! ```text
//! still     p = p0                          line   p = p0 + u (t - t0)
//! sine      p = p0 + a sin(2 pi f (t - t0) + phi)
//! waypoints p = p_i + (p_{i+1} - p_i) m(s),   s = (t - t_i) / (t_{i+1} - t_i)
//! ```
//!
//! where m(s) = s, or the minimum-jerk progress of [`crate::motion::minimum_jerk`], which rests at
//! every waypoint. The anchor rests at the first waypoint before its time, and at the last one
//! after its time.

use crate::math;
use crate::motion::minimum_jerk::minimum_jerk;
use nalgebra::Vector3;

/// Motion of an anchor. World axes, m, s.
#[derive(Clone, Debug, PartialEq)]
pub enum AnchorPath {
    /// It rests.
    Still,
    /// It drifts with this velocity u, m/s.
    Line(Vector3<f64>),
    /// It oscillates.
    Sine {
        /// Amplitude a along each axis, m.
        amplitude: Vector3<f64>,
        /// Frequency f, Hz.
        frequency: f64,
        /// Phase phi at the start, rad.
        phase: f64,
    },
    /// It passes points at instants in ascending order; at least one.
    Waypoints {
        /// Instants t_i (s) and points p_i.
        knots: Vec<(f64, Vector3<f64>)>,
        /// True for minimum-jerk moves between them, false for linear ones.
        smooth: bool,
    },
}

/// A moving point, from `origin` p0 at time `start` t0.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// p0, world, m. Not used by [`AnchorPath::Waypoints`].
    pub origin: Vector3<f64>,
    /// t0, s.
    pub start: f64,
    /// Its motion.
    pub path: AnchorPath,
}

impl Anchor {
    /// Position (m) and velocity (m/s) at `time`, on the smooth piece that contains `within`.
    pub fn at(&self, time: f64, within: f64) -> (Vector3<f64>, Vector3<f64>) {
        let t = time - self.start;
        match &self.path {
            AnchorPath::Still => (self.origin, Vector3::zeros()),
            AnchorPath::Line(velocity) => (self.origin + velocity * t, *velocity),
            AnchorPath::Sine { amplitude, frequency, phase } => {
                let rate = std::f64::consts::TAU * frequency;
                let (sin, cos) = math::sin_cos(rate * t + phase);
                (self.origin + amplitude * sin, amplitude * (rate * cos))
            }
            AnchorPath::Waypoints { knots, smooth } => interpolate(knots, *smooth, time, within),
        }
    }

    /// Instants at which its velocity or a derivative of it is discontinuous, s.
    pub fn corners(&self) -> impl Iterator<Item = f64> {
        let knots = match &self.path {
            AnchorPath::Waypoints { knots, .. } => &knots[..],
            _ => &[],
        };
        knots.iter().map(|(at, _)| *at)
    }
}

fn interpolate(knots: &[(f64, Vector3<f64>)], smooth: bool, time: f64, within: f64) -> (Vector3<f64>, Vector3<f64>) {
    let passed = knots.iter().take_while(|(at, _)| *at <= within).count();
    let (Some((from, a)), Some((to, b))) = (passed.checked_sub(1).map(|i| knots[i]), knots.get(passed)) else {
        // Before the first or after the last.
        return (knots[passed.saturating_sub(1)].1, Vector3::zeros());
    };
    let (t, length) = (time - from, to - from);
    let (progress, rate) = if smooth { minimum_jerk(t, length) } else { (t / length, 1.0 / length) };
    (a + (b - a) * progress, (b - a) * rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anchors() -> Vec<Anchor> {
        let p = |x, y| Vector3::new(x, y, 1.0);
        let knots = vec![(0.5, p(0.0, 0.0)), (1.0, p(1.0, 0.5)), (2.5, p(-1.0, 0.5))];
        let paths = [
            AnchorPath::Still,
            AnchorPath::Line(Vector3::new(1.0, -2.0, 0.5)),
            AnchorPath::Sine { amplitude: Vector3::new(0.1, 0.0, 0.3), frequency: 1.5, phase: 0.4 },
            AnchorPath::Waypoints { knots: knots.clone(), smooth: true },
            AnchorPath::Waypoints { knots, smooth: false },
        ];
        paths.map(|path| Anchor { origin: p(0.2, 0.3), start: 0.25, path }).into()
    }

    #[test]
    fn velocities_are_the_slopes_of_positions() {
        let h = 1e-5;
        for anchor in anchors() {
            for t in [0.3, 0.7, 0.9, 1.6, 2.3, 3.0] {
                let at = |t: f64| anchor.at(t, t).0;
                let slope = (at(t + h) - at(t - h)) / (2.0 * h);
                // A central difference: h^2 / 6 times the third derivative, which is at most 300
                // m/s^3; rounding 1e-16 / h.
                assert!((slope - anchor.at(t, t).1).norm() < 1e-8, "{anchor:?} {t}");
            }
        }
    }

    #[test]
    fn waypoints_are_reached_from_both_sides() {
        for anchor in anchors() {
            let AnchorPath::Waypoints { knots, smooth } = &anchor.path else { continue };
            for (at, point) in knots {
                for within in [at - 0.1, at + 0.1] {
                    let (position, velocity) = anchor.at(*at, within);
                    // Rounding of the interpolation.
                    assert!((position - point).norm() < 1e-15, "{at} {within}");
                    assert!(!smooth || velocity == Vector3::zeros(), "at rest in {at}");
                }
            }
            assert_eq!(anchor.at(0.0, 0.0), (knots[0].1, Vector3::zeros()));
            assert_eq!(anchor.at(9.0, 9.0), (knots[2].1, Vector3::zeros()));
            assert_eq!(anchor.corners().collect::<Vec<_>>(), [0.5, 1.0, 2.5]);
        }
    }
}
