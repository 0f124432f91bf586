//! The history of results: a Parquet file to which `runner compare` appends, and comparisons with it.
//!
//! ```text
//! results -> append -> history.parquet -> History -> newest (rows as Results) -> compare -> Changes
//!                                                 -> series (values of a run over the results) -> trends
//! ```
//!
//! - `columns`: names of the columns; `result_rows`: the rows of a result, and its digest.
//! - `history_table`: a history in memory; `append`: adds a result under a lock, in a new file.
//! - `newest`: the newest rows as results; `series`: the last values of each run and metric, and trends.
//! - `baseline`: results against a baseline, which is a history or other results; `baseline_text`: the
//!   same for the terminal.
//! - `curves`: the values of a metric over the results, for the report.
//!
//! Imports: `text`, `input`, `metrics`, `statistics`, `files`, `results`, `compare`. Used by:
//! `report`, `cli`.

mod append;
mod baseline;
mod baseline_text;
mod columns;
mod curves;
mod history_error;
mod history_table;
mod newest;
mod result_rows;
mod series;

pub use append::{AppendError, Appended, KEPT_RESULTS, MOST_ROWS, append};
pub use baseline::{Baseline, BaselineError, ColumnOverview, Compared, Overview, ResultChanges, TrendRule};
pub use columns::HISTORY_SCHEMA;
pub use curves::{Curve, MetricCurves, metric_curves};
pub use history_error::{HistoryError, HistoryErrorCause};
pub use history_table::{Entry, History};
pub use series::{HistoryChanges, Series, Trend};
