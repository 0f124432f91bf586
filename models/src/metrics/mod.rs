//! Measurements of a run: one table of metrics, with names, units, kinds and meanings.
//!
//! - `table`: the table, and the struct [`Metrics`] generated from it,
//! - `kind`: types of metrics,
//! - `column`: columns of the summary,
//! - `number`: real numbers in JSON.
//!
//! To add a column, add a row to `table` and set its field where it is measured.
//!
//! `sim` fills [`Metrics`]; `scenario` uses the names for `[[expect]]`; `results` writes records
//! and summaries.
//!
//! Imports: nothing of this crate. Used by: `sim`, `scenario`, `results`, `compare`, `report`,
//! `history`.

pub mod column;
mod kind;
pub mod number;
mod table;

pub use column::{COLUMNS, Column, ColumnSource, Cost, Distance, Known, column, is_distance, names_unit, unit};
pub use column::{METRICS, NUMERIC_COLUMNS, column_reference};
pub use number::Measure;
pub use table::Metrics;
