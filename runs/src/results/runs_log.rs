//! `runs.jsonl`: one line of JSON as each run ends, with the summary's names. A killed batch leaves
//! every line it wrote. The writer locks the file, and with it the folder of results, until it is dropped
//! or the process ends.

use crate::files::checksum::{self, Layout};
use crate::files::{RecordError, atomic, confined, durability, json};
use crate::metrics::{COLUMNS, number::Real};
use crate::results::SummaryRow;
use crate::results::results_lock::{self, Hold};
use crate::results::summary::TEXT_COLUMNS;
use serde::{Deserialize, Serialize, Serializer, ser::SerializeMap};
use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// An open `runs.jsonl`.
#[derive(Debug)]
pub struct RunsLog {
    path: PathBuf,
    file: Mutex<File>,
}

impl RunsLog {
    /// Opens the file to append to it, after creating it and its folder if needed. Removes an
    /// incomplete last line.
    ///
    /// # Errors
    /// The folder or file cannot be written; another program has it open to append.
    pub fn append(path: &Path) -> Result<Self, RecordError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
            // This file alone is written in place: a link would lead the writes elsewhere.
            confined::check(folder, path)?;
        }
        // A pipe would block, or lose the lines.
        if path.symlink_metadata().is_ok_and(|about| !about.is_file()) {
            let source = std::io::Error::new(ErrorKind::InvalidInput, "exists and is not a file: remove it");
            return Err(RecordError::Io { path: path.to_owned(), source });
        }
        let open = || OpenOptions::new().create(true).read(true).append(true).open(path);
        let mut file = results_lock::locked(path, Hold::Alone, open)?;
        remove_torn_line(&mut file).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(file) })
    }

    /// Opens the file for new results and empties it.
    ///
    /// # Errors
    /// See [`RunsLog::append`].
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let log = Self::append(path)?;
        log.file().set_len(0).map_err(RecordError::io(path))?;
        Ok(log)
    }

    /// Appends one run. Threads write in turn.
    ///
    /// # Errors
    /// The file cannot be written; then it ends with the last line that could.
    pub fn push(&self, row: &SummaryRow) -> Result<(), RecordError> {
        let line = encoded(row).map_err(|source| RecordError::Json { path: self.path.clone(), source })?;
        let mut file = self.file();
        let before = file.metadata().map(|m| m.len());
        // One unbuffered write per line: lines of a killed program are complete or absent.
        // The file may have been read; one without its damaged lines is not open to append.
        let written = file.seek(SeekFrom::End(0)).and_then(|_| file.write_all(&line));
        let written = written.and_then(|()| durability::sync_file(&file));
        written.map_err(|source| {
            // A full disk accepts the beginning of a line, which is removed here; devices cannot be
            // truncated.
            let _ = before.and_then(|length| file.set_len(length));
            RecordError::Io { path: self.path.clone(), source }
        })
    }

    /// Locks the file. A thread that panicked left whole lines.
    fn file(&self) -> MutexGuard<'_, File> {
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The runs with an intact line. Removes damaged lines.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn logged(&self) -> Result<LoggedRuns, RecordError> {
        let mut file = self.file();
        let (logged, damaged) = read_lines(&mut file).map_err(RecordError::io(&self.path))?;
        if damaged {
            // A file with the intact lines, which is locked before it has the name.
            let (intact, temporary) = atomic::temporary(&self.path)?;
            copy_intact_lines(&mut file, &intact).map_err(RecordError::io(&self.path))?;
            atomic::publish(temporary, &self.path)?;
            *file = intact;
        }
        Ok(logged)
    }
}

impl Drop for RunsLog {
    /// Closing the file is not enough: a process that was forked and has not started its program has it open too.
    fn drop(&mut self) {
        let _ = self.file().unlock();
    }
}

/// The runs with an intact line, and whether other lines are damaged.
fn read_lines(file: &mut File) -> std::io::Result<(LoggedRuns, bool)> {
    file.seek(SeekFrom::Start(0))?;
    let (mut logged, mut damaged) = (LoggedRuns::default(), false);
    for line in BufReader::new(file).split(b'\n') {
        match logged_run(&line?) {
            Some(run) => drop(logged.0.insert(run)),
            None => damaged = true,
        }
    }
    Ok((logged, damaged))
}

fn copy_intact_lines(from: &mut File, to: &File) -> std::io::Result<()> {
    from.seek(SeekFrom::Start(0))?;
    let mut out = BufWriter::new(to);
    for line in BufReader::new(from).split(b'\n') {
        let line = line?;
        if logged_run(&line).is_some() {
            out.write_all(&line)?;
            out.write_all(b"\n")?;
        }
    }
    out.flush()
}

/// Hashes of the runs with a line; there may be millions.
#[derive(Debug, Default)]
pub struct LoggedRuns(HashSet<u64>);

impl LoggedRuns {
    /// The run has a line.
    pub fn contains(&self, scenario: &str, key: &str) -> bool {
        self.0.contains(&digest(scenario, key))
    }

    /// Number of runs.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Hash of the run of a line; none if the line is damaged.
fn logged_run(line: &[u8]) -> Option<u64> {
    #[derive(Deserialize)]
    struct Run {
        scenario: String,
        key: String,
    }
    let Run { scenario, key } = serde_json::from_slice(line).ok()?;
    checksum::is_intact(line, Layout::Line).then(|| digest(&scenario, &key))
}

fn digest(scenario: &str, key: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    (scenario, key).hash(&mut hasher);
    hasher.finish()
}

/// Removes an incomplete last line, which would spoil the next one.
fn remove_torn_line(file: &mut File) -> std::io::Result<()> {
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

/// The line of a run, with its checksum and end.
fn encoded(row: &SummaryRow) -> serde_json::Result<Vec<u8>> {
    let mut line = json::compact(&Line(row))?;
    checksum::append(&mut line, Layout::Line);
    line.push(b'\n');
    Ok(line)
}

/// A row as a flat object: parameters under their dotted names, as in the summary; empty cells are
/// null. Without the checksum.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_of_the_open_file_does_not_keep_the_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let log = RunsLog::append(&path).unwrap();
        let _forked = log.file().try_clone().unwrap();
        assert!(matches!(RunsLog::append(&path), Err(RecordError::InUse { .. })));
        drop(log);
        RunsLog::append(&path).unwrap();
    }
}
