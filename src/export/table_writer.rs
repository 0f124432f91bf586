//! Writes a table as CSV, Parquet or text.

use crate::export::data_table::DataTable;
use crate::export::export_error::ExportError;
use crate::export::text_format::TextFormat;
use crate::files::{RecordError, atomic};
use std::io::Write;
use std::path::Path;

/// File format of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum TableFormat {
    /// Comma-separated values with a header; numbers have the fewest digits that read back to the
    /// same number.
    Csv,
    /// Parquet.
    Parquet,
    /// Columns of text.
    Text(TextFormat),
}

/// Writes a table to a temporary file and renames it to `path`, so that an existing file is
/// complete.
///
/// # Errors
/// The folder or file cannot be written, or the format names a column that the table does not have.
pub fn write(table: &DataTable, format: &TableFormat, path: &Path) -> Result<(), ExportError> {
    let bytes = to_bytes(table, format)?;
    Ok(atomic::write_named(path, atomic::OutputKind::Table, |out| {
        out.write_all(&bytes).map_err(RecordError::io(path))
    })?)
}

/// The table as bytes.
///
/// # Errors
/// The format names a column that the table does not have.
pub fn to_bytes(table: &DataTable, format: &TableFormat) -> Result<Vec<u8>, ExportError> {
    let mut bytes = Vec::new();
    match format {
        TableFormat::Csv => table.write_csv(&mut bytes)?,
        TableFormat::Parquet => table.write_parquet(&mut bytes)?,
        TableFormat::Text(text) => text.write(table, &mut bytes)?,
    }
    Ok(bytes)
}
