//! Exports time series and events of a log as tables: CSV, Parquet, and text for gnuplot and
//! similar programs. Exports a whole log as a ROS 2 bag.
//!
//! ```text
//! Trajectory -> named columns with units -> chosen columns -> chosen instants -> DataTable -> file
//! BagLog -> chosen instants -> ROS 2 messages -> folder
//! ```
//!
//! Imports: `geometry`, `text`, `files`, `log`. Used by: `replay`, `cli`, `console`, `fit`.

pub mod bag;
mod column_choice;
mod data_table;
mod export_error;
mod log_columns;
mod log_instants;
mod log_tables;
mod number_format;
mod selection;
mod table_writer;
mod text_format;
mod text_options;

pub use data_table::{DataTable, Values};
pub use export_error::ExportError;
pub use log_tables::{column_names, events, series};
pub use number_format::{NumberFormat, NumberFormatError};
pub use selection::Selection;
pub use table_writer::{TableFormat, to_bytes, write};
pub use text_format::{HeaderStyle, TextFormat, TimeUnit};
pub use text_options::{TextOptionError, separator, visible};
