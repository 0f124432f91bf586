//! Results of runs: records, summary, and what is computed from many of them.
//!
//! | room | content |
//! |---|---|
//! | `record` | `run.json`, the record of one run |
//! | `summary` | `summary.csv`, `summary.parquet`, statistics |
//! | `runs_log`, `shard_list`, `junit` | `runs.jsonl`, `shard.jsonl`, JUnit XML |
//! | `results_lock` | the lock of a folder of results |
//! | `discovery` | finds the records below a folder |
//! | `claims` | judges statements about all runs |
//! | `searches` | results of searches |
//! | `pareto` | error over cost |
//! | `table`, `verdict` | tables for the terminal |
//!
//! All files but `runs.jsonl` are written to a temporary file and renamed, so an existing file is
//! whole. Simulated results depend on the run alone; wall-clock times have columns and an object of
//! their own.
//!
//! Imports: `math`, `text`, `input`, `metrics`, `contact`, `sim`, `statistics`, `scenario`,
//! `files`. Used by: `report`, `batch`, `replay`, `view`, `cli`, `submit`, `history`, `compare`,
//! `merge`.

pub mod claims;
mod discovery;
mod junit;
mod log_fingerprint;
mod overview;
pub mod pareto;
mod record;
mod reference_motion;
mod results_lock;
mod runs_log;
pub mod searches;
mod shard_list;
mod summary;
mod table;
mod verdict;
mod verdict_table;

pub use crate::metrics::{Measure, NUMERIC_COLUMNS};
pub use discovery::{FoundRun, ListedRows, Listing, Records, SampledRuns, list_records, read_records, unfinished_logs};
pub use junit::{JunitCase, JunitStatus, write_junit};
pub use log_fingerprint::{LogFingerprint, LogMismatch, log_mismatch};
pub use overview::overview;
pub use record::{
    BUILD, Comparison, InputHash, Machine, PROGRAM, ParamValue, RUN_SCHEMA, Repeats, RunRecord, Timing, TruthError,
    hash_input, is_truth,
};
pub use reference_motion::{Comparator, ReferenceMotion};
pub use results_lock::ResultsLock;
pub use runs_log::{LoggedRuns, RunsLog};
pub use shard_list::{PlanHash, SHARD_LIST, SHARD_SCHEMA, ShardHead, ShardList, ShardRun};
pub use summary::{
    BoundedSample, Rows, RunStatistics, SAMPLE_SIZE, ScenarioStatistics, SummaryColumns, SummaryFiles, SummaryRow,
    measure, metric, truth_columns, write_summary, write_summary_of,
};
pub use table::{endings, table};
pub use verdict::Verdict;
pub use verdict_table::{ListedVerdicts, verdicts};
