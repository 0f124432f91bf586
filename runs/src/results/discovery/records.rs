//! Reads the records below a folder of results.

use super::run_order::{Digest, SortKey, digest, summary_order};
use crate::files::{KeyLevels, RecordError, names};
use crate::results::RunRecord;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

/// The records below a folder.
#[derive(Debug)]
pub struct Records {
    /// Runs: in the order of `summary.csv` where it names them, then by scenario, parameters and
    /// seed.
    pub runs: Vec<FoundRun>,
    /// Reference runs, in the order in which the runs first need them.
    pub references: Vec<FoundRun>,
    /// Errors of files and folders that were skipped: a `run.json` of another program, a broken
    /// one, an unreadable folder.
    pub skipped: Vec<RecordError>,
}

/// A run with its record and files.
#[derive(Debug)]
pub struct FoundRun {
    /// The record.
    pub record: RunRecord,
    /// `run.json`, and `log.mcap` and `problems` if they exist.
    pub files: Vec<PathBuf>,
}

impl FoundRun {
    /// Keeps of a record what a report shows, without the texts of scenario and inputs.
    pub fn without_inputs(path: PathBuf, record: RunRecord) -> Self {
        let record = RunRecord { resolved: String::new(), inputs: Vec::new(), ..record };
        FoundRun { record, files: files(path) }
    }
}

/// Reads every `run.json` below a folder. Links to folders are not followed; folders whose names
/// begin with a dot are skipped.
///
/// # Errors
/// The folder itself cannot be read.
pub fn read_records(folder: &Path) -> Result<Records, RecordError> {
    let (mut runs, mut references): (Vec<FoundRun>, Vec<FoundRun>) = Default::default();
    let skipped = for_each_record(folder, &mut |is_reference, path, record| {
        if is_reference { &mut references } else { &mut runs }.push(FoundRun { record, files: files(path) });
    })?;
    let order = summary_order(&folder.join(names::SUMMARY_CSV));
    runs.sort_by_cached_key(|run| SortKey::of(&run.record, &order));
    let needed: Vec<&str> = runs.iter().filter_map(|r| r.record.comparison.reference.as_deref()).collect();
    let first_use = |r: &FoundRun| needed.iter().position(|key| *key == r.record.key).unwrap_or(needed.len());
    references.sort_by_cached_key(first_use);
    Ok(Records { runs, references, skipped })
}

/// Calls `visit` once for each run and reference run below a folder, with its record; returns the
/// errors of skipped files.
pub(super) fn for_each_record(
    folder: &Path,
    visit: &mut dyn FnMut(bool, PathBuf, RunRecord),
) -> Result<Vec<RecordError>, RecordError> {
    let mut skipped = Vec::new();
    // An unreadable root is an error of the call; unreadable folders below it are skipped.
    std::fs::read_dir(folder).map_err(RecordError::io(folder))?;
    let mut known: HashMap<Digest, Box<Path>> = HashMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let (own, below) = match entries(&folder) {
            Ok(found) => found,
            Err(error) => {
                skipped.push(error);
                continue;
            }
        };
        // The stack pops the last one: this visits folders in alphabetical order.
        folders.extend(below.into_iter().rev());
        let Some(path) = own else { continue };
        match RunRecord::read(&path) {
            Ok(record) => {
                let is_reference = is_reference(&path, &record);
                match known.entry(digest(is_reference, &record.scenario, &record.key)) {
                    Entry::Occupied(other) => {
                        skipped.push(RecordError::Duplicate { path, other: other.get().to_path_buf() });
                    }
                    Entry::Vacant(free) => {
                        free.insert(path.clone().into_boxed_path());
                        visit(is_reference, path, record);
                    }
                }
            }
            Err(error) => skipped.push(error),
        }
    }
    Ok(skipped)
}

/// Reference runs are in `SCENARIO/references/KEY`, other runs in `SCENARIO/KEY`; there may be
/// folders above `KEY`.
fn is_reference(path: &Path, record: &RunRecord) -> bool {
    let references = Path::new(&record.scenario).join(names::REFERENCES);
    KeyLevels::all().zip(path.ancestors().skip(1)).any(|(levels, folder)| {
        let own = levels.folder(&record.key);
        let is_key = levels.is_none() || path.parent().is_some_and(|path| path.ends_with(own));
        is_key && folder.parent().is_some_and(|above| above.ends_with(&references))
    })
}

/// The `run.json` of a folder, and its subfolders by name.
fn entries(folder: &Path) -> Result<(Option<PathBuf>, Vec<PathBuf>), RecordError> {
    let (mut own, mut below) = (None, Vec::new());
    for entry in std::fs::read_dir(folder).map_err(RecordError::io(folder))? {
        let entry = entry.map_err(RecordError::io(folder))?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        match entry.file_type().map_err(RecordError::io(&entry.path()))? {
            kind if kind.is_dir() => below.extend((!hidden).then(|| entry.path())),
            _ if entry.file_name() == names::RUN_RECORD => own = Some(entry.path()),
            _ => {}
        }
    }
    below.sort();
    Ok((own, below))
}

fn files(record: PathBuf) -> Vec<PathBuf> {
    let others = [names::LOG, names::PROBLEMS].map(|name| record.with_file_name(name));
    std::iter::once(record).chain(others.into_iter().filter(|path| path.exists())).collect()
}
