//! Rows of a Parquet table. The table has columns, so its rows are first written to a temporary
//! file, some ten thousand at a time.

use std::fs::File;
use std::io::{BufWriter, Cursor, Read, Write};

use polars::prelude::{AnyValue, DataFrame, PolarsError};
use polars_io::SerReader;
use polars_io::parquet::read::{ParallelStrategy, ParquetReader};

use crate::compare::columns::{Columns, RunDigest, digest};
use crate::compare::file_spans::{FileSpans, Span};
use crate::compare::row_source::{Opened, ResultsErrorCause, Rows};
use crate::files::catch_panic;

/// Rows that are in memory at a time.
const SLICE: usize = 25_000;

/// The rows of a table: for each cell the length of its text, 4 bytes, and the text.
pub(super) struct ParquetRows {
    file: FileSpans,
    rows: Vec<Span>,
}

impl ParquetRows {
    /// Reads a table. The library panics at some damaged files.
    pub fn open(mut file: File) -> Opened {
        // In memory: the library would map the file, and a program that shortens it would end this one.
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let read = catch_panic(|| Self::read_table(&bytes));
        read.unwrap_or_else(|panic| Err(ResultsErrorCause::DamagedTable(panic)))
    }

    fn read_table(bytes: &[u8]) -> Opened {
        let mut table = ParquetReader::new(Cursor::new(bytes));
        let columns = Columns::new(table.schema()?.iter_names().map(ToString::to_string));
        let height = table.num_rows()?;
        let metadata = table.get_metadata()?.clone();
        let mut out = BufWriter::new(tempfile::tempfile()?);
        let (mut rows, mut runs): (Vec<Span>, Vec<RunDigest>) = Default::default();
        let (mut offset, mut cells) = (0, vec![String::new(); columns.len()]);
        let identity = ["scenario", "key"].map(|name| columns.position(name));
        for begin in (0..height).step_by(SLICE) {
            let slice = (begin, SLICE.min(height - begin));
            // On this thread, where a panic is caught.
            let mut reader = ParquetReader::new(Cursor::new(bytes)).read_parallel(ParallelStrategy::None);
            reader.set_metadata(metadata.clone());
            let frame = reader.with_slice(Some(slice)).finish()?;
            if frame.height() != slice.1 {
                return Err(ResultsErrorCause::DamagedTable(format!("it has fewer rows than it states, {height}")));
            }
            for row in 0..frame.height() {
                let mut length = 0;
                for (column, cell) in cells.iter_mut().enumerate() {
                    write_cell(&frame, column, row, cell)?;
                    out.write_all(&(cell.len() as u32).to_le_bytes())?;
                    out.write_all(cell.as_bytes())?;
                    length += 4 + cell.len();
                }
                rows.push(Span { offset, length });
                offset += length as u64;
                runs.push(digest(identity.map(|position| position.map_or("", |position| cells[position].as_str()))));
            }
        }
        let file = FileSpans::new(out.into_inner().map_err(std::io::IntoInnerError::into_error)?)?;
        Ok((columns, runs, Box::new(ParquetRows { file, rows })))
    }
}

impl Rows for ParquetRows {
    fn read(&mut self, position: usize, _: &Columns, cells: &mut [String]) -> Result<(), ResultsErrorCause> {
        let mut rest = self.file.read(self.rows[position])?;
        for cell in cells {
            let (length, after) =
                rest.split_first_chunk().ok_or(std::io::ErrorKind::UnexpectedEof).map_err(std::io::Error::from)?;
            let (text, after) = after
                .split_at_checked(u32::from_le_bytes(*length) as usize)
                .ok_or(std::io::ErrorKind::UnexpectedEof)
                .map_err(std::io::Error::from)?;
            cell.push_str(std::str::from_utf8(text).map_err(std::io::Error::other)?);
            rest = after;
        }
        Ok(())
    }
}

fn write_cell(frame: &DataFrame, column: usize, row: usize, cell: &mut String) -> Result<(), PolarsError> {
    match frame.columns()[column].get(row)? {
        AnyValue::Null => cell.clear(),
        AnyValue::String(text) => cell.replace_range(.., text),
        AnyValue::StringOwned(text) => cell.replace_range(.., text.as_str()),
        // The shortest text that reads back to the same number.
        AnyValue::Float64(x) => *cell = format!("{x:?}"),
        other => *cell = other.to_string(),
    }
    Ok(())
}
