//! People who look on while a run is made: what they are told, and how fast.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::log::MessageSink;

/// How often a second of a run is told when its scenario wants no log.
pub(in crate::batch) const RATE: f64 = 60.0;
/// A run that is later than this is not made to catch up.
const LATE: Duration = Duration::from_millis(100);
/// How long it sleeps without looking whether it is cancelled.
const SLICE: Duration = Duration::from_millis(50);

/// Somebody who looks on.
pub trait LiveClients: Sync {
    /// Takes what the log holds.
    fn outlet(&self) -> Box<dyn MessageSink>;
    /// Called once the run has described itself, before its first step: may wait for somebody, until it is cancelled.
    fn wait(&self, cancel: &AtomicBool);
    /// How often somebody began to look: whoever came while nothing moved has seen nothing yet.
    fn arrivals(&self) -> u64;
    /// Simulated seconds per second; none: as fast as it goes.
    fn pace(&self) -> Option<f64>;
    /// The run is over.
    fn farewell(&self);
    /// What there is to tell a person of all this, after the end. It is no part of the run, which is the same for nobody.
    fn told(&self) -> Vec<String>;
}

/// Makes a run wait at the instants of its log, by the clock on the wall.
pub(in crate::batch) struct Pacer {
    pace: f64,
    /// When simulated time 0 was, or would have been.
    start: Option<Instant>,
}

impl Pacer {
    pub fn new(pace: f64) -> Self {
        Pacer { pace, start: None }
    }

    /// Waits until a simulated time is due, or until it is cancelled.
    pub fn wait(&mut self, time: f64, cancel: &AtomicBool) {
        let due = self.due(time, Instant::now());
        while !cancel.load(Ordering::Relaxed)
            && let left = due.saturating_duration_since(Instant::now())
            && !left.is_zero()
        {
            sleep(left.min(SLICE));
        }
    }

    /// When a simulated time is due, asked at `now`.
    fn due(&mut self, time: f64, now: Instant) -> Instant {
        // A pace so small that the clock cannot hold it waits until it is cancelled.
        let after = Duration::try_from_secs_f64(time / self.pace).unwrap_or(Duration::from_secs(u32::MAX.into()));
        let start = self.start.get_or_insert(now);
        if now > *start + after + LATE {
            *start = now.checked_sub(after).unwrap_or(*start);
        }
        *start + after
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(n: u64) -> Duration {
        Duration::from_millis(n)
    }

    #[test]
    fn instants_are_due_at_the_pace() {
        let (mut pacer, start) = (Pacer::new(10.0), Instant::now());
        for k in 0..10 {
            let due = pacer.due(0.05 * k as f64, start + ms(5 * k) - ms(k.min(1)));
            // Durations are whole nanoseconds.
            assert!(due.duration_since(start).abs_diff(ms(5 * k)) < Duration::from_nanos(2), "instant {k}");
        }
    }

    #[test]
    fn what_was_late_is_not_caught_up() {
        let (mut pacer, start) = (Pacer::new(1.0), Instant::now());
        let near = |a: Instant, b: Instant| a.max(b).duration_since(a.min(b)) < Duration::from_nanos(2);
        assert!(near(pacer.due(0.0, start), start));
        // A little late is made up for, much is not.
        assert!(near(pacer.due(0.01, start + ms(60)), start + ms(10)));
        assert!(near(pacer.due(0.02, start + ms(150)), start + ms(150)));
        assert!(near(pacer.due(0.05, start + ms(151)), start + ms(180)));
    }

    #[test]
    fn it_ends_when_it_is_cancelled() {
        let mut pacer = Pacer::new(1e-300);
        pacer.wait(0.0, &AtomicBool::new(false));
        pacer.wait(1.0, &AtomicBool::new(true));
    }
}
