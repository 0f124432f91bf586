//! Finds recorded runs by key, folder or file.

use crate::files::{RecordError, json, names};
use crate::replay::replay_error::ReplayError;
use crate::results::{RunRecord, read_records};
use crate::sim::Outcome;
use std::path::{Path, PathBuf};

/// A run with its files.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Its `run.json`.
    pub path: PathBuf,
    /// Contents of `run.json`.
    pub record: RunRecord,
    /// Its log, if there is one.
    pub log: Option<PathBuf>,
}

impl RecordedRun {
    /// Reads a `run.json`.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(path: &Path) -> Result<Self, ReplayError> {
        let record = RunRecord::read(path)?;
        let log = Some(path.with_file_name(names::LOG)).filter(|log| log.exists());
        Ok(Self { path: path.to_owned(), record, log })
    }

    /// True if another program has removed or replaced the record since it was read.
    pub fn has_changed(&self) -> bool {
        // As bytes, in which equal values that are not numbers are equal.
        let bytes = |record: &RunRecord| json::compact(record).ok();
        RunRecord::read(&self.path).map_or(true, |now| bytes(&now) != bytes(&self.record))
    }

    /// True if a time limit or a user terminated the run; a re-run does not end at the same
    /// instant.
    pub fn terminated_externally(&self) -> bool {
        matches!(self.record.outcome, Outcome::TimedOut | Outcome::Cancelled)
    }
}

/// Finds the run of a folder or of a `run.json`, the runs of a folder of results, or the run below
/// `results` whose key begins with `target`. Reference runs are found as well.
///
/// Of a folder of results, also returns why records in it cannot be read.
///
/// # Errors
/// There is none, or several keys begin with the text.
pub fn find(target: &str, results: &Path) -> Result<(Vec<RecordedRun>, Vec<RecordError>), ReplayError> {
    let path = Path::new(target);
    if path.is_file() {
        return Ok((vec![RecordedRun::read(path)?], Vec::new()));
    }
    if path.join(names::RUN_RECORD).is_file() {
        return Ok((vec![RecordedRun::read(&path.join(names::RUN_RECORD))?], Vec::new()));
    }
    let folder = if path.is_dir() { path } else { results };
    let mut records = read_records(folder)?;
    records.runs.append(&mut records.references);
    let matches = |key: &str| path.is_dir() || key.starts_with(target);
    let matching = records.runs.into_iter().filter(|run| matches(&run.record.key));
    // The first file of a run is its record.
    let found: Vec<RecordedRun> = matching.map(|run| RecordedRun::read(&run.files[0])).collect::<Result<_, _>>()?;
    if found.is_empty() && !path.is_dir() {
        return Err(ReplayError::UnknownKey { key: target.to_owned(), results: results.to_owned() });
    }
    // One run may occur in several scenarios; its key is the same.
    if !path.is_dir() && found.iter().any(|run| run.record.key != found[0].record.key) {
        let names: Vec<_> = found.iter().map(|l| format!("{} {}", l.record.scenario, l.record.key)).collect();
        return Err(ReplayError::AmbiguousKey { key: target.to_owned(), found: names.join(", ") });
    }
    // Among runs of other keys damaged records do not matter.
    let skipped = if path.is_dir() { records.skipped } else { Vec::new() };
    Ok((found, skipped))
}
