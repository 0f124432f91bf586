//! Re-runs a recorded run and compares the result with the record, bit for bit.
//!
//! ```text
//! run.json -> resolved scenario -> one run in a new folder -> its run.json and log.mcap -> differences
//! ```
//!
//! A record holds the scenario with every value written out, and the hashes of its input files. The files themselves are
//! read from where they were; changed files are reported. Imports `batch`, `results`, `export`, `log`; called by `cli`.

mod compare_logs;
mod compare_records;
mod compare_runs;
mod difference;
mod input_change;
mod recorded_run;
mod replay_error;
mod rerun;

pub use compare_runs::compare;
pub use difference::Difference;
pub use input_change::InputChange;
pub use recorded_run::{RecordedRun, find};
pub use replay_error::ReplayError;
pub use rerun::{PreparedRerun, Rerun, prepare};
