//! The desired motion of the joints: commanded positions with estimated velocities, accelerations
//! and jerk, and their extrapolation.
//!
//! Commanded velocities are used where they fit the positions,
//! `|dq - (v + v') T / 2| <= T (|dv| + |dv'|) / 4` with the time T between ticks, dv the change of
//! velocity in this tick and dv' in the last one (a smooth motion of jerk j deviates by j T^3 / 12,
//! and dv changes by j T^2). Their change is the acceleration. Otherwise both are backward
//! differences over [`WINDOW`], long enough that the last digits of a filtered reading do not
//! appear as acceleration. If these show a jerk near the limit, only the velocity common to two
//! windows is used.

use super::Limits;
use crate::collision::kinematics::capped_travel;
use crate::math;
use crate::motion::spline::TrajectoryPoint;

/// Time over which differences are taken, s, or one tick if that is longer.
const WINDOW: f64 = 0.01;

/// Fraction of the jerk limit below which a motion without usable velocities counts as smooth.
const SMOOTH: f64 = 0.25;

/// Rounding of positions, rad or m.
const ROUNDING: f64 = 1e-12;

/// Positions of all joints at the last ticks, enough for three windows.
pub(super) struct PositionHistory {
    period: f64,
    /// Ticks per window.
    stride: usize,
    joints: usize,
    /// Positions tick by tick.
    all: Vec<f64>,
    newest: usize,
}

impl PositionHistory {
    /// At rest at `start`, with ticks every `period` seconds.
    pub fn new(start: &[f64], period: f64) -> Self {
        let stride = (WINDOW / period - 1e-9).ceil().max(1.0) as usize;
        PositionHistory { period, stride, joints: start.len(), all: start.repeat(3 * stride + 1), newest: 0 }
    }

    /// Adds a tick and returns its positions to fill in.
    pub fn next(&mut self) -> &mut [f64] {
        self.newest = (self.newest + 1) % (3 * self.stride + 1);
        &mut self.all[self.newest * self.joints..(self.newest + 1) * self.joints]
    }

    /// Length of a window, s.
    pub fn window(&self) -> f64 {
        self.stride as f64 * self.period
    }

    /// The position `k` windows ago.
    fn back(&self, j: usize, k: usize) -> f64 {
        self.ago(j, k * self.stride)
    }

    fn ago(&self, j: usize, ticks: usize) -> f64 {
        let n = 3 * self.stride + 1;
        self.all[(self.newest + n - ticks) % n * self.joints + j]
    }

    /// Whether `next` as the next position keeps the limits over the windows that end there, and
    /// hardly jumps.
    pub fn may_be_followed_by(&self, j: usize, next: f64, limits: &Limits) -> bool {
        let (h, t) = (self.window(), self.period);
        let [a, b, c] = [1, 2, 3].map(|k| self.ago(j, k * self.stride - 1));
        let jump = next - 2.0 * self.ago(j, 0) + self.ago(j, 1);
        let more = 1.0 + 1e-6;
        ((next - a) / h).abs() <= limits.speed * more
            && ((next - 2.0 * a + b) / (h * h)).abs() <= limits.acceleration * more
            && ((next - 3.0 * a + 3.0 * b - c) / (h * h * h)).abs() <= limits.jerk * more
            && jump.abs() <= limits.acceleration * t * t + NOISE
    }
}

/// Jump of a position between ticks that counts as the last digits of a reading, rad or m.
const NOISE: f64 = 1e-4;

/// The desired motion of all joints.
pub(super) struct DesiredMotion {
    period: f64,
    history: PositionHistory,
    velocity: Vec<f64>,
    /// Change of the commanded velocity from tick to tick.
    change: Vec<f64>,
    now: Vec<TrajectoryPoint>,
    before: Vec<TrajectoryPoint>,
    /// Number of ticks for which the commanded velocities fit, at most 3.
    fitting: Vec<u32>,
}

impl DesiredMotion {
    /// At rest at `start`, with ticks every `period` seconds.
    pub fn new(start: &[f64], period: f64) -> Self {
        let now: Vec<TrajectoryPoint> = start.iter().map(|&q| TrajectoryPoint { q, v: 0.0, a: 0.0 }).collect();
        DesiredMotion {
            period,
            history: PositionHistory::new(start, period),
            velocity: vec![0.0; start.len()],
            change: vec![0.0; start.len()],
            before: now.clone(),
            fitting: vec![3; start.len()],
            now,
        }
    }

    /// Adds the commands of the next tick.
    pub fn push(&mut self, position: &[f64], velocity: &[f64], limits: &[Limits]) {
        for ((to, commanded), limit) in self.history.next().iter_mut().zip(position).zip(limits) {
            *to = commanded.clamp(limit.lower, limit.upper);
        }
        self.before.copy_from_slice(&self.now);
        for (j, limit) in limits.iter().enumerate() {
            let fits = self.fits(j, position[j], velocity[j]);
            self.fitting[j] = if fits { (self.fitting[j] + 1).min(3) } else { 0 };
            self.now[j] = self.estimate(j, velocity[j], limit.jerk);
        }
        for (j, v_commanded) in velocity.iter().enumerate() {
            self.change[j] = v_commanded - self.velocity[j];
        }
        self.velocity.copy_from_slice(velocity);
    }

    /// Whether the commanded velocity of this tick fits the commanded position.
    fn fits(&self, j: usize, commanded: f64, v_commanded: f64) -> bool {
        let (t, last) = (self.period, self.velocity[j]);
        let q = self.history.back(j, 0);
        let bend = q - self.before[j].q - 0.5 * t * (v_commanded + last);
        let changes = (v_commanded - last).abs() + self.change[j].abs();
        // If the range clips the position, the commanded velocity does not belong to the motion.
        q == commanded && bend.abs() <= 0.25 * t * changes + ROUNDING
    }

    fn estimate(&self, j: usize, v_commanded: f64, jerk: f64) -> TrajectoryPoint {
        let q = self.history.back(j, 0);
        if self.fitting[j] > 0 {
            return TrajectoryPoint { q, v: v_commanded, a: (v_commanded - self.velocity[j]) / self.period };
        }
        let h = self.history.window();
        let (x, y) = (self.history.back(j, 1), self.history.back(j, 2));
        let (last, first) = ((q - x) / h, (x - y) / h);
        let acceleration = (last - first) / h;
        if self.mean_jerk(j).abs() <= SMOOTH * jerk {
            return TrajectoryPoint { q, v: last + 0.5 * h * acceleration, a: acceleration };
        }
        // A step has no velocity: use only the part common to both windows.
        let both = if last * first > 0.0 { last.signum() * last.abs().min(first.abs()) } else { 0.0 };
        TrajectoryPoint { q, v: both, a: 0.0 }
    }

    /// The motion at the last tick.
    pub fn now(&self, j: usize) -> TrajectoryPoint {
        self.now[j]
    }

    /// The motion at the tick before.
    pub fn before(&self, j: usize) -> TrajectoryPoint {
        self.before[j]
    }

    /// Its jerk: from tick to tick where commanded velocities fit, otherwise the mean over the last
    /// three windows.
    pub fn jerk(&self, j: usize) -> f64 {
        if self.fitting[j] == 3 {
            return (self.now[j].a - self.before[j].a) / self.period;
        }
        self.mean_jerk(j)
    }

    fn mean_jerk(&self, j: usize) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.history.back(j, k));
        (a - 3.0 * b + 3.0 * c - d) / math::powi(self.history.window(), 3)
    }

    /// Whether the commanded velocities fit the positions.
    pub fn has_velocity(&self, j: usize) -> bool {
        self.fitting[j] == 3
    }

    /// Whether it keeps the limits; otherwise it cannot be extrapolated.
    fn keeps(&self, j: usize, limits: &Limits) -> bool {
        let TrajectoryPoint { v, a, .. } = self.now[j];
        let more = 1.0 + 1e-6;
        v.abs() <= limits.speed * more
            && a.abs() <= limits.acceleration * more
            && self.jerk(j).abs() <= limits.jerk * more
    }

    /// Extrapolates by `ahead` seconds from the last tick: constant acceleration for `horizon`,
    /// then constant speed for `horizon` more, within the limits of speed and range. A motion that
    /// breaks a limit, such as a step, stays at its position.
    pub fn ahead(&self, j: usize, ahead: f64, horizon: f64, limits: &Limits) -> TrajectoryPoint {
        let TrajectoryPoint { q, v, a } = self.now[j];
        if !self.keeps(j, limits) {
            return TrajectoryPoint { q, v: 0.0, a: 0.0 };
        }
        let s = ahead.min(horizon);
        let reached = q + capped_travel(v, a, limits.speed, s);
        let speed = (v.clamp(-limits.speed, limits.speed) + a * s).clamp(-limits.speed, limits.speed);
        let on = (ahead - s).min(horizon);
        let position = reached + speed * on;
        let within = position.clamp(limits.lower, limits.upper);
        if within != position || ahead > 2.0 * horizon {
            return TrajectoryPoint { q: within, v: 0.0, a: 0.0 };
        }
        let a = if on > 0.0 { 0.0 } else { a.clamp(-limits.acceleration, limits.acceleration) };
        TrajectoryPoint { q: position, v: speed, a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: [Limits; 1] = [Limits { lower: -2.0, upper: 2.0, speed: 5.0, acceleration: 40.0, jerk: 800.0 }];

    /// q = 0.5 sin(3 t), with or without its velocity, up to 1 s.
    fn sine(period: f64, v_commanded: bool) -> DesiredMotion {
        let mut desired = DesiredMotion::new(&[0.0], period);
        for k in 1..=(1.0 / period).round() as i32 {
            let t = f64::from(k) * period;
            desired.push(&[0.5 * (3.0 * t).sin()], &[if v_commanded { 1.5 * (3.0 * t).cos() } else { 0.0 }], &LIMITS);
        }
        desired
    }

    #[test]
    fn motions_are_estimated_with_and_without_velocities() {
        let (v, a, jerk) = (1.5 * 3f64.cos(), -4.5 * 3f64.sin(), -13.5 * 3f64.cos());
        for (v_commanded, window) in [(true, 0.001), (false, 0.01)] {
            let found = sine(0.001, v_commanded);
            let now = found.now(0);
            // Backward differences: v to h^2 q''' / 3 (exact with velocity), a to h q''' and half
            // of that with velocity.
            assert!(
                (now.v - v).abs() <= if v_commanded { 0.0 } else { 13.5 * window * window / 3.0 * 1.1 },
                "{now:?} {v}"
            );
            assert!((now.a - a).abs() <= 13.5 * window * 1.1, "{now:?} {a}");
            // The mean of the last 30 ms lags by 15 ms (1 ms with velocity); the fourth derivative
            // is at most 40.5.
            let lag = if v_commanded { 0.001 } else { 0.015 };
            assert!((found.jerk(0) - jerk).abs() <= 40.5 * lag * 1.1, "{} {jerk}", found.jerk(0));
        }
    }

    #[test]
    fn a_velocity_that_does_not_fit_the_positions_is_ignored() {
        let mut desired = DesiredMotion::new(&[0.0], 0.002);
        for k in 1..=100 {
            desired.push(&[0.002 * f64::from(k)], &[0.0], &LIMITS);
        }
        // A ramp of 1 per second, to rounding of 0.2 over a window of 10 ms.
        assert!((desired.now(0).v - 1.0).abs() < 1e-12 && desired.now(0).a.abs() < 1e-10, "{:?}", desired.now(0));
    }

    #[test]
    fn extrapolation_keeps_speed_and_range() {
        let mut desired = DesiredMotion::new(&[0.0], 0.1);
        for k in 1..=4 {
            let t = 0.1 * f64::from(k);
            desired.push(&[2.0 * t * t], &[4.0 * t], &LIMITS);
        }
        // At 0.32 with 1.6 per second and 4 more each second.
        let p = desired.ahead(0, 0.1, 0.1, &LIMITS[0]);
        assert!((p.q - 0.5).abs() < 1e-12 && (p.v - 2.0).abs() < 1e-12 && (p.a - 4.0).abs() < 1e-9, "{p:?}");
        // The acceleration ends after the horizon; the speed then reached lasts as long again, and
        // the motion rests.
        let p = desired.ahead(0, 0.15, 0.1, &LIMITS[0]);
        assert!((p.q - 0.6).abs() < 1e-12 && (p.v - 2.0).abs() < 1e-12 && p.a == 0.0, "{p:?}");
        let p = desired.ahead(0, 1.0, 0.1, &LIMITS[0]);
        assert!((p.q - 0.7).abs() < 1e-12 && p.v == 0.0 && p.a == 0.0, "{p:?}");
        let slow = Limits { speed: 1.8, ..LIMITS[0] };
        // 1.8 is reached after 50 ms: 0.085 there, 0.09 in the rest.
        assert!((desired.ahead(0, 0.1, 0.1, &slow).q - (0.32 + 0.085 + 0.09)).abs() < 1e-12);
        let near = Limits { upper: 0.4, ..LIMITS[0] };
        assert_eq!(desired.ahead(0, 0.1, 0.1, &near), TrajectoryPoint { q: 0.4, v: 0.0, a: 0.0 });
    }
}
