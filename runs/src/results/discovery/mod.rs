//! Finds the records below a folder of results: all in memory, or a listing of their paths.
//!
//! Imports `results::record` and `results::summary`. `runner report`, `replay` and `view` call it.

mod listing;
mod records;
mod run_order;
mod unfinished_logs;

pub use listing::{ListedRows, Listing, SampledRuns, list_records};
pub use records::{FoundRun, Records, read_records};
pub use unfinished_logs::unfinished_logs;
