//! The summary over many runs: rows and columns, files, statistics, and a bounded sample of the
//! runs.
//!
//! Imports `results::record` and `metrics`. A batch, `runner report` and `runner merge` write
//! summaries.

mod bounded_sample;
mod run_statistics;
mod summary_files;
mod summary_row;

pub use bounded_sample::{BoundedSample, SAMPLE_SIZE};
pub use run_statistics::RunStatistics;
pub use run_statistics::ScenarioStatistics;
pub use summary_files::{Rows, SummaryColumns, SummaryFiles, write_summary, write_summary_of};
pub(super) use summary_files::{parameter, parameter_names};
pub(super) use summary_row::TEXT_COLUMNS;
pub use summary_row::{SummaryRow, measure, metric, truth_columns};
