//! `runs.jsonl`: one line of JSON as each run ends, with the summary's names. A batch that is killed leaves every line
//! it wrote.

use super::columns::{COLUMNS, Number, TEXT_COLUMNS};
use super::number::Real;
use super::{RecordError, SummaryRow};
use serde::{Serialize, Serializer, ser::SerializeMap};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// An open `runs.jsonl`.
pub struct RunsLog {
    path: PathBuf,
    file: File,
    line: Vec<u8>,
}

impl RunsLog {
    /// Opens the file to append to it; it and its folder are created if need be.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn append(path: &Path) -> Result<Self, RecordError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
        }
        let mut file =
            OpenOptions::new().create(true).read(true).append(true).open(path).map_err(RecordError::io(path))?;
        end_torn_line(&mut file).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), file, line: Vec::new() })
    }

    /// Appends one run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, row: &SummaryRow) -> Result<(), RecordError> {
        self.line.clear();
        serde_json::to_writer(&mut self.line, &Line(row))
            .map_err(|source| RecordError::Json { path: self.path.clone(), source })?;
        self.line.push(b'\n');
        // One write per line, straight to the file: lines of a killed program are whole or absent.
        self.file.write_all(&self.line).and_then(|()| self.file.flush()).map_err(RecordError::io(&self.path))
    }
}

/// A crash in the middle of a line must not spoil the next one.
fn end_torn_line(file: &mut File) -> std::io::Result<()> {
    if file.metadata()?.len() == 0 {
        return Ok(());
    }
    let mut last = [0];
    file.seek(SeekFrom::End(-1))?;
    file.read_exact(&mut last)?;
    if last != *b"\n" { file.write_all(b"\n") } else { Ok(()) }
}

/// A row as a flat object: parameters under their dotted names, as in the summary; empty cells are null.
struct Line<'a>(&'a SummaryRow);

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let row = self.0;
        let mut map = serializer.serialize_map(None)?;
        for column in TEXT_COLUMNS {
            map.serialize_entry(column.name, (column.get)(row))?;
        }
        map.serialize_entry("seed", &row.seed)?;
        for (name, value) in &row.parameters {
            map.serialize_entry(name, value)?;
        }
        for column in COLUMNS {
            match (column.get)(row) {
                Number::Count(n) => map.serialize_entry(column.name, &n)?,
                Number::Real(x) => map.serialize_entry(column.name, &x.map(Real))?,
            }
        }
        for truth in &row.comparison.truth {
            map.serialize_entry(&truth.column(), &truth.error.map(Real))?;
        }
        map.serialize_entry("verdicts", &row.verdicts)?;
        map.end()
    }
}
