//! The runs that are meant by a key or a folder.

use super::ReplayError;
use crate::results::{RunRecord, read_records};
use crate::sim::Outcome;
use std::path::{Path, PathBuf};

/// What a run left.
#[derive(Clone, Debug)]
pub struct Left {
    /// Its `run.json`.
    pub path: PathBuf,
    /// What is in it.
    pub record: RunRecord,
    /// Its log, if it left one.
    pub log: Option<PathBuf>,
}

impl Left {
    /// Reads a `run.json`.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(path: &Path) -> Result<Self, ReplayError> {
        let record = RunRecord::read(path)?;
        let log = Some(path.with_file_name("log.mcap")).filter(|log| log.exists());
        Ok(Self { path: path.to_owned(), record, log })
    }

    /// Was the run ended from outside, by a time limit or a person: at a moment that no other run has.
    pub fn was_cut(&self) -> bool {
        matches!(self.record.outcome, Outcome::TimedOut | Outcome::Cancelled)
    }
}

/// The run of a folder or of a `run.json`, the runs of a folder of results, or the run below `results` whose key begins
/// as `what`. Reference runs are found as well.
///
/// # Errors
/// There is none, or a key means several.
pub fn find(what: &str, results: &Path) -> Result<Vec<Left>, ReplayError> {
    let path = Path::new(what);
    if path.is_file() {
        return Ok(vec![Left::read(path)?]);
    }
    if path.join("run.json").is_file() {
        return Ok(vec![Left::read(&path.join("run.json"))?]);
    }
    let folder = if path.is_dir() { path } else { results };
    let mut records = read_records(folder)?;
    records.runs.append(&mut records.references);
    let is_meant = |key: &str| path.is_dir() || key.starts_with(what);
    let meant = records.runs.into_iter().filter(|run| is_meant(&run.record.key));
    // The first file of a run is its record.
    let found: Vec<Left> = meant.map(|run| Left::read(&run.files[0])).collect::<Result<_, _>>()?;
    if found.is_empty() && !path.is_dir() {
        return Err(ReplayError::Unknown { key: what.to_owned(), results: results.to_owned() });
    }
    // A run of several scenarios may be one and the same; keys of different runs are not.
    if !path.is_dir() && found.iter().any(|left| left.record.key != found[0].record.key) {
        let names: Vec<_> = found.iter().map(|l| format!("{} {}", l.record.scenario, l.record.key)).collect();
        return Err(ReplayError::Ambiguous { key: what.to_owned(), found: names.join(", ") });
    }
    Ok(found)
}
