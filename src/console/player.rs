//! Clock of a playback: the times at which its lines are due.

use std::time::{Duration, Instant};

/// State of a playback.
#[derive(Clone, Debug)]
pub struct Player {
    /// Names and patterns of the columns that are printed.
    pub columns: Vec<String>,
    /// Recorded seconds per second; negative: backwards; `None`: without waiting.
    pub speed: Option<f64>,
    /// Recorded time between lines, s.
    pub period: f64,
    /// Recorded time, s, and wall time at the start.
    pub start: (f64, Instant),
    /// Recorded time of the end, s.
    pub to: f64,
    /// Number of lines shown.
    pub lines: u64,
}

impl Player {
    /// The recorded time of the next line, s.
    pub fn next(&self) -> f64 {
        let elapsed = self.lines as f64 * self.period;
        self.start.0 + if self.backwards() { -elapsed } else { elapsed }
    }

    /// True if the recorded time decreases.
    fn backwards(&self) -> bool {
        self.speed.is_some_and(|speed| speed < 0.0) || self.to < self.start.0
    }

    /// True once the end is passed.
    pub fn finished(&self) -> bool {
        let next = self.next();
        if self.backwards() { next < self.to - 1e-9 } else { next > self.to + 1e-9 }
    }

    /// Time until the next line is due.
    pub fn due(&self) -> Duration {
        let Some(speed) = self.speed else { return Duration::ZERO };
        let at = (self.next() - self.start.0).abs() / speed.abs();
        Duration::try_from_secs_f64(at).unwrap_or(Duration::MAX).saturating_sub(self.start.1.elapsed())
    }
}
