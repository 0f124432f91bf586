//! What a run costs. A run lives on one thread, so that thread's processor time is the run's.

use std::time::Instant;

use cpu_time::ThreadTime;

use crate::record::{Machine, Timing};

/// Started with a run, on its thread.
pub(super) struct Clock {
    wall: Instant,
    cpu: Option<ThreadTime>,
}

impl Clock {
    pub fn start() -> Self {
        // Not every system has a clock per thread; NaN says so.
        Self { wall: Instant::now(), cpu: ThreadTime::try_now().ok() }
    }

    /// Time since the start; to be called on the same thread.
    pub fn read(&self) -> Timing {
        let cpu_s = self.cpu.and_then(|c| c.try_elapsed().ok()).map_or(f64::NAN, |d| d.as_secs_f64());
        Timing { wall_s: self.wall.elapsed().as_secs_f64(), cpu_s, machine: Machine::here(), repeats: None }
    }
}
