//! What a run leaves, and the summary over many runs.
//!
//! | file | written by |
//! |---|---|
//! | `log.mcap` | [`LogWriter`], an [`Observer`](crate::sim::Observer) of one run; read by [`Trajectory`] |
//! | `run.json` | [`RunRecord`] |
//! | `problems/*.json` | [`ProblemWriter`], when asked for |
//! | `runs.jsonl` | [`RunsLog`], one line as each run ends |
//! | `summary.csv`, `summary.parquet` | [`write_summary`] |
//! | `report.html` | [`write_report`] |
//! | `--junit FILE` | [`write_junit`] |
//!
//! [`export`] writes what a log holds as tables. [`table`], [`verdicts`] and [`pareto::pareto_table`] are what a person sees of all this. Every file
//! but `runs.jsonl` is written beside its final name and renamed when complete, so a file that is there is whole. Simulated
//! results depend on the run alone; wall-clock figures have columns and an object of their own.

pub mod changes;
pub(crate) mod columns;
mod comparison;
mod junit;
mod kept;
mod listing;
mod log_fingerprint;
pub mod merge;
pub(crate) mod parameter;
pub mod pareto;
pub(crate) mod rebuild;
mod reference_motion;
pub(crate) mod run;
mod runs_log;
mod shard_list;
pub(crate) mod summary;
pub(crate) mod table;
pub(crate) mod tally;
pub(crate) mod verdict;

pub use crate::metrics::{Measure, NUMERIC_COLUMNS};
pub use columns::{SummaryRow, measure, metric, truth_columns};
pub use comparison::{Comparison, Repeats, TruthError};
pub use junit::{JunitCase, JunitStatus, write_junit};
pub use kept::{Kept, MOST_KEPT};
pub use listing::{ListedRows, Listing, Seen, list_records};
pub use log_fingerprint::{LogFingerprint, log_fault};
pub use parameter::{ParamValue, is_truth};
pub use rebuild::{FoundRun, Records, read_records};
pub use reference_motion::{Comparator, ReferenceMotion};
pub use run::{BUILD, InputHash, Machine, PROGRAM, RUN_SCHEMA, RunRecord, Timing, hash_input};
pub use runs_log::{RunsLog, Told};
pub use shard_list::{PlanHash, SHARD_LIST, SHARD_SCHEMA, ShardHead, ShardList, ShardRun};
pub use summary::{Rows, SummaryFiles, summary_frame, write_summary, write_summary_of};
pub use table::table;
pub use tally::Tally;
pub use verdict::{Shown, Verdict, verdicts};
