//! Options of a batch.

use std::num::NonZero;
use std::path::PathBuf;
use std::time::Duration;

use crate::sim::Problems;

/// Settings of a batch.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of the results; created if missing.
    pub output: PathBuf,
    /// Threads, at least 1.
    pub jobs: usize,
    /// True writes `log.mcap` where the scenario requests one.
    pub log: bool,
    /// Wall-clock limit of each run.
    pub timeout: Option<Duration>,
    /// Number of unaccepted runs after which no more runs start; none: start all.
    pub max_fail: Option<NonZero<usize>>,
    /// Wall-clock time after which an active run is reported as slow.
    pub slow: Option<Duration>,
    /// Contact problems to write below each run's folder.
    pub problems: Problems,
    /// True repeats runs for timing where their scenarios request it.
    pub timing: bool,
    /// True skips runs whose results exist.
    pub resume: bool,
}

impl Default for Options {
    /// Results in `results`, one thread per processor, logs as scenarios request, no limits.
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
