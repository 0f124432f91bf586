//! Connects live clients to a run and paces it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::log::MessageSink;

/// Snapshot rate for live clients of a run without a log, Hz.
pub(in crate::batch) const RATE: f64 = 60.0;
/// Delay beyond which a run does not catch up.
const LATE: Duration = Duration::from_millis(100);
/// Longest sleep between checks for cancellation.
const SLICE: Duration = Duration::from_millis(50);

/// Clients that observe a run while it is simulated.
pub trait LiveClients: Sync {
    /// Sink for the messages of the log.
    fn sink(&self) -> Box<dyn MessageSink>;
    /// Called after the log's header, before the first step; may wait for a client or `cancel`.
    fn wait(&self, cancel: &AtomicBool);
    /// Number of client arrivals; a client that arrives while the run is paused has seen no data.
    fn arrivals(&self) -> u64;
    /// Simulated seconds per second; none: unlimited.
    fn pace(&self) -> Option<f64>;
    /// Sends everything that is queued at the end of the run.
    fn finish(&self);
    /// Notes for the user. They are not part of the run, which is the same without clients.
    fn notes(&self) -> Vec<String>;
}

/// Delays a run at the instants of its log to match the wall clock.
pub(in crate::batch) struct Pacer {
    pace: f64,
    /// Wall-clock instant of simulated time 0.
    start: Option<Instant>,
}

impl Pacer {
    pub fn new(pace: f64) -> Self {
        Pacer { pace, start: None }
    }

    /// Waits until a simulated time is due or the run is cancelled.
    pub fn wait(&mut self, time: f64, cancel: &AtomicBool) {
        let due = self.due(time, Instant::now());
        while !cancel.load(Ordering::Relaxed)
            && let remaining = due.saturating_duration_since(Instant::now())
            && !remaining.is_zero()
        {
            sleep(remaining.min(SLICE));
        }
    }

    /// Instant at which a simulated time is due, evaluated at `now`.
    fn due(&mut self, time: f64, now: Instant) -> Instant {
        // A pace too small for the clock waits until cancelled.
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
    fn long_delays_are_not_caught_up() {
        let (mut pacer, start) = (Pacer::new(1.0), Instant::now());
        let near = |a: Instant, b: Instant| a.max(b).duration_since(a.min(b)) < Duration::from_nanos(2);
        assert!(near(pacer.due(0.0, start), start));
        // A short delay is caught up, a long one is not.
        assert!(near(pacer.due(0.01, start + ms(60)), start + ms(10)));
        assert!(near(pacer.due(0.02, start + ms(150)), start + ms(150)));
        assert!(near(pacer.due(0.05, start + ms(151)), start + ms(180)));
    }

    #[test]
    fn waiting_ends_when_the_run_is_cancelled() {
        let mut pacer = Pacer::new(1e-300);
        pacer.wait(0.0, &AtomicBool::new(false));
        pacer.wait(1.0, &AtomicBool::new(true));
    }
}
