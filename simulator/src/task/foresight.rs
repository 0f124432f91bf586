//! How far ahead the commands of a task are known.
//!
//! Commands of a task without feedback are a function of time, piecewise smooth. While all running
//! tasks are such, the server can compute commands ahead of time ([`super::Task::command_at`]),
//! and leave out ticks that would bring nothing new.

/// How far ahead commands are known, from the last call of a task on. Times in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foresight {
    /// Until then they are a function of time alone; negative infinity: not at all.
    pub until: f64,
    /// Until then that function is smooth; at most `until`.
    pub smooth_until: f64,
}

impl Foresight {
    /// Commands depend on more than time, or may.
    pub const NONE: Foresight = Foresight { until: f64::NEG_INFINITY, smooth_until: f64::NEG_INFINITY };
    /// Commands do not change.
    pub const UNLIMITED: Foresight = Foresight { until: f64::INFINITY, smooth_until: f64::INFINITY };

    /// Known after `now` until `until`, with a kink at each of `kinks`; those not after `now` do not count.
    pub fn new(now: f64, until: f64, kinks: impl IntoIterator<Item = f64>) -> Self {
        let ahead = kinks.into_iter().filter(|kink| *kink > now + 1e-9);
        Foresight { until, smooth_until: ahead.fold(until, f64::min) }
    }

    /// What is known of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Foresight { until: self.until.min(other.until), smooth_until: self.smooth_until.min(other.smooth_until) }
    }

    /// Known until `time` at most.
    #[must_use]
    pub fn within(self, time: f64) -> Self {
        self.and(Foresight { until: time, smooth_until: time })
    }
}
