//! Options of a batch.

use std::num::NonZero;
use std::path::PathBuf;
use std::time::Duration;

use crate::sim::Problems;

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of the results; created if need be.
    pub output: PathBuf,
    /// Threads, at least 1.
    pub jobs: usize,
    /// Write `log.mcap` where the scenario wants one?
    pub log: bool,
    /// Wall-clock limit of each run.
    pub timeout: Option<Duration>,
    /// Start no more runs once so many failed or did not finish; none: start all.
    pub max_fail: Option<NonZero<usize>>,
    /// Wall-clock time after which a run that is still going is told of as slow.
    pub slow: Option<Duration>,
    /// Contact problems to write below each run's folder.
    pub problems: Problems,
    /// Repeat runs whose scenarios ask for it, to time them?
    pub timing: bool,
    /// Make only those runs whose results are not there?
    pub resume: bool,
}

impl Default for Options {
    /// Results in `results`, one thread per processor, logs where scenarios want them, no limits.
    fn default() -> Self {
        Self {
            output: PathBuf::from("results"),
            jobs: std::thread::available_parallelism().map_or(1, NonZero::get),
            log: true,
            timeout: None,
            max_fail: None,
            slow: None,
            problems: Problems::None,
            timing: true,
            resume: false,
        }
    }
}
