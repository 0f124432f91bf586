//! Re-runs a recorded run and compares the result with the record, bit for bit.
//!
//! ```text
//! run.json -> resolved scenario -> run in a new folder -> run.json, log.mcap -> differences
//! ```
//!
//! A record has the resolved scenario and the hashes of its input files. The files themselves are
//! read from their recorded paths; changed files are reported.
//!
//! Imports: `sim`, `scenario`, `files`, `log`, `results`, `batch`, `report`, `export`. Used by:
//! `cli`.

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
