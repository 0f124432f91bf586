//! What a run measures: one table of metrics, with names, units, kinds and meanings.
//!
//! `table` holds the table and the struct [`Metrics`] generated from it; `kind` the types of metrics; `column` the summary's
//! columns; `number` the JSON form of real numbers. To add a column, add a row to `table` and set its field where it is
//! measured.
//!
//! Imports nothing of this crate. `sim` fills [`Metrics`]; `scenario` takes the names for `[[expect]]`; `results` writes
//! records and summaries.

mod column;
mod kind;
pub(crate) mod number;
mod table;

pub(crate) use column::{COLUMNS, Column, ColumnSource, Cost, Distance, Known, column, is_distance, names_unit, unit};
pub use column::{METRICS, NUMERIC_COLUMNS, column_reference};
pub use number::Measure;
pub use table::Metrics;
