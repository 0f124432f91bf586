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
//!
//! [`export`] writes what a log holds as tables. [`table`], [`verdicts`] and [`pareto::pareto_table`] are what a person sees of all this. Every file
//! but `runs.jsonl` is written beside its final name and renamed when complete, so a file that is there is whole. Simulated
//! results depend on the run alone; wall-clock figures have columns and an object of their own.

pub(crate) mod atomic;
pub mod changes;
mod columns;
mod comparison;
mod error;
pub mod export;
mod log;
mod number;
mod parameter;
pub mod pareto;
mod problems;
mod rebuild;
mod reference_motion;
mod report;
mod run;
mod runs_log;
mod summary;
mod table;
mod verdict;

pub use columns::{NUMERIC_COLUMNS, SummaryRow, metric, truth_columns};
pub use comparison::{Comparison, Repeats, TruthError};
pub use error::RecordError;
pub use log::messages;
pub use log::{Attachment, JointSeries, LogError, LoggedEvent, Motion, PointSeries, RunInfo};
pub use log::{Document, LogHeader, LogWriter, ParseTopicError, Topics, ros};
pub use log::{EstimateSeries, Frame, JointReadings, Scene, SelfCollisionSeries, SoleReadings};
pub use log::{SoleSeries, Trajectory, VertexSeries};
pub use parameter::{ParamValue, is_truth};
pub use problems::{MAX_PROBLEMS, PROBLEM_SCHEMA, ProblemRecord, ProblemWriter};
pub use rebuild::{FoundRun, Records, read_records};
pub use reference_motion::{Comparator, ReferenceMotion};
pub use report::{Pictured, ReportRun, write_report};
pub use run::{InputHash, Machine, PROGRAM, RUN_SCHEMA, RunRecord, Timing, hash_input};
pub use runs_log::RunsLog;
pub use summary::{SummaryFiles, summary_frame, write_summary};
pub use table::table;
pub use verdict::{Shown, Verdict, verdicts};
