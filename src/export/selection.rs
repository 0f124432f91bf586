//! The selected part of a log.

/// Largest number of rows of a table.
pub(super) const MAX_ROWS: f64 = 1e7;

/// Columns and instants to export. By default all, as they were logged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Names of columns, in which `*` matches any characters and `?` one character; all columns
    /// when empty. The time is always the first column.
    pub columns: Vec<String>,
    /// Rows per simulated second, Hz; `None` for the instants of the log.
    pub rate: Option<f64>,
    /// First instant, s.
    pub from: Option<f64>,
    /// Last instant, s.
    pub to: Option<f64>,
}
