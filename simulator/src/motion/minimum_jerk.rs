//! Minimum-jerk transitions [Flash 1985, equation A9]: the quintic from rest to rest, and
//! parameters that change along it, with their integral in closed form.
//!
//! ```text
//! p(t) = p0 + (p1 - p0) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t0) / T
//! integral from t0 of p dt = p0 (t - t0) + (p1 - p0) T (5/2 s^4 - 3 s^5 + s^6)     (s <= 1)
//! ```

use crate::math;

/// Progress and its rate (1/s) of a minimum-jerk move of length `duration` at time `t` after its
/// start.
pub fn minimum_jerk(t: f64, duration: f64) -> (f64, f64) {
    if t >= duration {
        return (1.0, 0.0);
    }
    let s = (t / duration).max(0.0);
    (s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration)
}

/// A parameter that changes to new values without a jump of its rate. Times in s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SmoothTransition {
    from: f64,
    to: f64,
    start: f64,
    duration: f64,
}

impl SmoothTransition {
    /// A value that is constant from `start` on.
    pub fn constant(value: f64, start: f64) -> Self {
        SmoothTransition { from: value, to: value, start, duration: 0.0 }
    }

    /// Changes to `value` within `duration` seconds (0: at once), from its value at `time`.
    pub fn change(&mut self, value: f64, time: f64, duration: f64) {
        *self = SmoothTransition { from: self.value(time), to: value, start: time, duration };
    }

    /// The end of the last change, s.
    pub fn end(&self) -> f64 {
        self.start + self.duration
    }

    /// Value at a time.
    pub fn value(&self, time: f64) -> f64 {
        match minimum_jerk(time - self.start, self.duration).0 {
            1.0 => self.to,
            progress => self.from + (self.to - self.from) * progress,
        }
    }

    /// Its rate, per s.
    pub fn rate(&self, time: f64) -> f64 {
        (self.to - self.from) * minimum_jerk(time - self.start, self.duration).1
    }

    /// Integral from the last change (or the start) to a later time.
    pub fn integral(&self, time: f64) -> f64 {
        let t = time - self.start;
        if t >= self.duration {
            return self.to * t - 0.5 * (self.to - self.from) * self.duration;
        }
        let s = t / self.duration;
        self.from * t + (self.to - self.from) * self.duration * math::powi(s, 4) * (2.5 - s * (3.0 - s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_jerk_has_its_closed_form() {
        assert_eq!(minimum_jerk(0.0, 2.0), (0.0, 0.0));
        assert_eq!(minimum_jerk(2.0, 2.0), (1.0, 0.0));
        let (half, peak) = minimum_jerk(1.0, 2.0);
        // Half way at half time; the greatest rate is 15/8 of the mean.
        assert!((half - 0.5).abs() < 1e-15 && (peak - 15.0 / 16.0).abs() < 1e-15);
        // The rate is the derivative: central difference, error of order h^2 times the third
        // derivative (60 / T^3).
        let h = 1e-5;
        let slope = (minimum_jerk(0.7 + h, 2.0).0 - minimum_jerk(0.7 - h, 2.0).0) / (2.0 * h);
        assert!((slope - minimum_jerk(0.7, 2.0).1).abs() < 1e-9);
    }

    #[test]
    fn rate_and_integral_match_the_value() {
        let mut transition = SmoothTransition::constant(2.0, 1.0);
        assert_eq!((transition.value(5.0), transition.rate(5.0), transition.integral(5.0)), (2.0, 0.0, 8.0));
        transition.change(-1.0, 5.0, 0.8);
        let h = 1e-5;
        for t in [5.1, 5.4, 5.7, 5.9, 7.0] {
            let slope = (transition.value(t + h) - transition.value(t - h)) / (2.0 * h);
            let area = (transition.integral(t + h) - transition.integral(t - h)) / (2.0 * h);
            // h^2 / 6 times third derivatives of some 3 * 60 / T^3, and rounding over h.
            assert!((slope - transition.rate(t)).abs() < 1e-7 && (area - transition.value(t)).abs() < 1e-8, "{t}");
        }
        assert_eq!((transition.value(5.0), transition.value(6.0), transition.integral(5.0)), (2.0, -1.0, 0.0));
        // Half the change in half the time: the mean of a transition is that of its ends.
        assert!((transition.integral(5.8) - 0.4).abs() < 1e-15);
        transition.change(3.0, 5.4, 0.0);
        assert_eq!((transition.value(5.4), transition.rate(5.4), transition.integral(6.4)), (3.0, 0.0, 3.0));
    }
}
