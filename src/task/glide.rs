//! A parameter that goes over from one value to another without a jump of its rate: the minimum-jerk path of `posture`,
//! with its integral in closed form.
//!
//! ```text
//! p(t) = p0 + (p1 - p0) (10 s^3 - 15 s^4 + 6 s^5),   s = (t - t0) / T
//! integral from t0 of p dt = p0 (t - t0) + (p1 - p0) T (5/2 s^4 - 3 s^5 + s^6)     (s <= 1)
//! ```

use super::posture::minimum_jerk;

/// See the module. Times in s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Glide {
    from: f64,
    to: f64,
    start: f64,
    duration: f64,
}

impl Glide {
    /// A value that stays from `start` on.
    pub fn constant(value: f64, start: f64) -> Self {
        Glide { from: value, to: value, start, duration: 0.0 }
    }

    /// From where it is at `time` to `value` within `duration` seconds (0: at once).
    pub fn turn(&mut self, value: f64, time: f64, duration: f64) {
        *self = Glide { from: self.value(time), to: value, start: time, duration };
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

    /// Integral from the last turn (or the start) to a time behind it.
    pub fn integral(&self, time: f64) -> f64 {
        let t = time - self.start;
        if t >= self.duration {
            return self.to * t - 0.5 * (self.to - self.from) * self.duration;
        }
        let s = t / self.duration;
        self.from * t + (self.to - self.from) * self.duration * s.powi(4) * (2.5 - s * (3.0 - s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_and_integral_belong_to_the_value() {
        let mut glide = Glide::constant(2.0, 1.0);
        assert_eq!((glide.value(5.0), glide.rate(5.0), glide.integral(5.0)), (2.0, 0.0, 8.0));
        glide.turn(-1.0, 5.0, 0.8);
        let h = 1e-5;
        for t in [5.1, 5.4, 5.7, 5.9, 7.0] {
            let slope = (glide.value(t + h) - glide.value(t - h)) / (2.0 * h);
            let area = (glide.integral(t + h) - glide.integral(t - h)) / (2.0 * h);
            // h^2 / 6 times third derivatives of some 3 * 60 / T^3, and rounding over h.
            assert!((slope - glide.rate(t)).abs() < 1e-7 && (area - glide.value(t)).abs() < 1e-8, "{t}");
        }
        assert_eq!((glide.value(5.0), glide.value(6.0), glide.integral(5.0)), (2.0, -1.0, 0.0));
        // Half the way in half the time: the mean of a glide is that of its ends.
        assert!((glide.integral(5.8) - 0.4).abs() < 1e-15);
        glide.turn(3.0, 5.4, 0.0);
        assert_eq!((glide.value(5.4), glide.rate(5.4), glide.integral(6.4)), (3.0, 0.0, 3.0));
    }
}
