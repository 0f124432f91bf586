//! Delayed readings.

use nalgebra::{Quaternion, UnitQuaternion};

/// Stores the readings of the last `delay` seconds, by channel.
pub(super) struct Delay {
    delay: f64,
    channels: usize,
    /// Times of the stored readings; the newest at `head`.
    times: Vec<f64>,
    /// Their values, a row of channels each.
    values: Vec<f64>,
    head: usize,
    filled: usize,
}

/// Fraction of the period by which ticks may be early.
const EARLY: f64 = 1e-6;

impl Delay {
    /// For readings every `period` seconds or less often.
    pub fn new(channels: usize, delay: f64, period: f64) -> Self {
        // The two readings around the delayed instant, and all newer ones.
        let rows = if delay > 0.0 { (delay / (period * (1.0 - EARLY))).ceil() as usize + 2 } else { 0 };
        Delay { delay, channels, times: vec![0.0; rows], values: vec![0.0; rows * channels], head: 0, filled: 0 }
    }

    /// Stores the present readings and replaces them by those `delay` ago, interpolated linearly;
    /// before the start by the first ones.
    pub fn apply(&mut self, now: f64, readings: &mut [f64]) {
        let Some((newer, older, part)) = self.store(now, readings) else { return };
        let (newer, older) = (&self.values[newer * self.channels..], &self.values[older * self.channels..]);
        for (i, x) in readings.iter_mut().enumerate() {
            *x = if part == 0.0 { older[i] } else { older[i] + part * (newer[i] - older[i]) };
        }
    }

    /// The same for an orientation, along the shortest turn.
    pub fn apply_to_rotation(&mut self, now: f64, rotation: &mut UnitQuaternion<f64>) {
        let present: [f64; 4] = [rotation.i, rotation.j, rotation.k, rotation.w];
        let Some((newer, older, part)) = self.store(now, &present) else { return };
        let at = |row: usize| {
            let q = &self.values[4 * row..4 * row + 4];
            UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[0], q[1], q[2]))
        };
        *rotation = at(older).slerp(&at(newer), part);
    }

    /// Stores readings. Returns the rows after and before the instant `delay` ago and its position
    /// between them, 0 to 1; none without delay.
    fn store(&mut self, now: f64, readings: &[f64]) -> Option<(usize, usize, f64)> {
        let rows = self.times.len();
        if rows == 0 {
            return None;
        }
        self.head = (self.head + 1) % rows;
        self.filled = (self.filled + 1).min(rows);
        self.times[self.head] = now;
        self.values[self.head * self.channels..][..self.channels].copy_from_slice(readings);
        let instant = now - self.delay;
        let row = |back: usize| (self.head + rows - back) % rows;
        for back in 1..self.filled {
            let (newer, older) = (row(back - 1), row(back));
            if self.times[older] <= instant {
                let span = self.times[newer] - self.times[older];
                let part = if span > 0.0 { ((instant - self.times[older]) / span).min(1.0) } else { 0.0 };
                return Some((newer, older, part));
            }
        }
        let oldest = row(self.filled - 1);
        Some((oldest, oldest, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_ramp_comes_late_and_is_held_before_it_began() {
        for delay in [0.001, 0.0035, 0.02] {
            let mut line = Delay::new(2, delay, 0.001);
            for k in 0..100 {
                let t = f64::from(k) * 0.001;
                let mut x = [5.0 + t, -2.0 * t];
                line.apply(t, &mut x);
                let then = (t - delay).max(0.0);
                // A ramp is interpolated without error but rounding.
                assert!((x[0] - 5.0 - then).abs() < 1e-14 && (x[1] + 2.0 * then).abs() < 1e-14, "{delay} {t}");
            }
        }
    }

    #[test]
    fn without_delay_nothing_changes() {
        let mut line = Delay::new(1, 0.0, 0.001);
        let mut x = [0.1];
        line.apply(0.3, &mut x);
        assert_eq!(x, [0.1]);
    }

    #[test]
    fn a_steady_turn_comes_late() {
        let mut line = Delay::new(4, 0.0025, 0.001);
        let at = |t: f64| UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.6, 0.8) * 2.0 * t);
        for k in 0..50 {
            let t = f64::from(k) * 0.001;
            let mut r = at(t);
            line.apply_to_rotation(t, &mut r);
            // Rounding of the arc cosine near 1: square root of 1e-16.
            assert!(r.angle_to(&at((t - 0.0025).max(0.0))) < 1e-7, "{t}");
        }
    }
}
