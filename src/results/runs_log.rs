//! `runs.jsonl`: one line of JSON as each run ends, with the summary's names. A batch that is killed leaves every line
//! it wrote. Whoever has it open to append has the folder to himself: the lock ends with the program, however that ends.

use crate::files::{RecordError, confined};
use crate::metrics::{COLUMNS, number::Real};
use crate::results::SummaryRow;
use crate::results::columns::TEXT_COLUMNS;
use serde::{Deserialize, Serialize, Serializer, ser::SerializeMap};
use std::collections::HashSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// An open `runs.jsonl`.
pub struct RunsLog {
    path: PathBuf,
    file: File,
    line: Vec<u8>,
}

impl RunsLog {
    /// Opens the file to append to it; it and its folder are created if need be. What a crash left of a line is cut off.
    ///
    /// # Errors
    /// The folder or file cannot be written; another program has it open to append.
    pub fn append(path: &Path) -> Result<Self, RecordError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
            // It alone is written in place, so what a link leads to would be.
            confined::check(folder, path)?;
        }
        // A pipe would wait for another end, or keep nothing of what is written.
        if path.symlink_metadata().is_ok_and(|about| !about.is_file()) {
            let source = std::io::Error::new(ErrorKind::InvalidInput, "is there and is no file: remove it");
            return Err(RecordError::Io { path: path.to_owned(), source });
        }
        let mut file =
            OpenOptions::new().create(true).read(true).append(true).open(path).map_err(RecordError::io(path))?;
        match file.try_lock() {
            // A file system without locks has none to break.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => return Err(RecordError::InUse { path: path.to_owned() }),
        }
        cut_torn_line(&mut file).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), file, line: Vec::new() })
    }

    /// The same for results that are written anew: what the file held is gone.
    ///
    /// # Errors
    /// See [`RunsLog::append`].
    pub fn anew(path: &Path) -> Result<Self, RecordError> {
        let log = Self::append(path)?;
        log.file.set_len(0).map_err(RecordError::io(path))?;
        Ok(log)
    }

    /// Appends one run.
    ///
    /// # Errors
    /// The file cannot be written; then it ends with the last line that could.
    pub fn push(&mut self, row: &SummaryRow) -> Result<(), RecordError> {
        self.line.clear();
        serde_json::to_writer(&mut self.line, &Line(row))
            .map_err(|source| RecordError::Json { path: self.path.clone(), source })?;
        self.line.push(b'\n');
        let before = self.file.metadata().map(|m| m.len());
        // One write per line, straight to the file: lines of a killed program are whole or absent.
        self.file.write_all(&self.line).and_then(|()| self.file.flush()).map_err(|source| {
            // A disk that is full takes the beginning of a line; what cannot be shortened is no ordinary file.
            let _ = before.and_then(|length| self.file.set_len(length));
            RecordError::Io { path: self.path.clone(), source }
        })
    }

    /// The runs that have a line.
    ///
    /// # Errors
    /// The file cannot be read; that there is none is no error.
    pub fn told(path: &Path) -> Result<Told, RecordError> {
        #[derive(Deserialize)]
        struct Run {
            scenario: String,
            key: String,
        }
        let file = match File::open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Told::default()),
            file => file.map_err(RecordError::io(path))?,
        };
        let mut told = Told::default();
        for line in BufReader::new(file).split(b'\n') {
            // A line that is no run tells nothing.
            if let Ok(Run { scenario, key }) = serde_json::from_slice(&line.map_err(RecordError::io(path))?) {
                told.0.insert(digest(&scenario, &key));
            }
        }
        Ok(told)
    }
}

/// Runs that have a line, as their hashes: there may be millions.
#[derive(Debug, Default)]
pub struct Told(HashSet<u64>);

impl Told {
    /// Has this run a line?
    pub fn contains(&self, scenario: &str, key: &str) -> bool {
        self.0.contains(&digest(scenario, key))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn digest(scenario: &str, key: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    (scenario, key).hash(&mut hasher);
    hasher.finish()
}

/// A crash in the middle of a line must not spoil the next one.
fn cut_torn_line(file: &mut File) -> std::io::Result<()> {
    let length = file.metadata()?.len();
    let (mut end, mut block) = (length, [0; 4096]);
    while end > 0 {
        let size = block.len().min(end as usize);
        file.seek(SeekFrom::Start(end - size as u64))?;
        file.read_exact(&mut block[..size])?;
        if let Some(at) = block[..size].iter().rposition(|b| *b == b'\n') {
            end -= (size - at - 1) as u64;
            break;
        }
        end -= size as u64;
    }
    if end < length { file.set_len(end) } else { Ok(()) }
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
        for column in &COLUMNS {
            map.serialize_entry(column.name, &row.cell(column))?;
        }
        for truth in &row.comparison.truth {
            map.serialize_entry(&truth.column(), &truth.error.map(Real))?;
        }
        map.serialize_entry("verdicts", &row.verdicts)?;
        map.end()
    }
}
