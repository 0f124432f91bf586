//! The records below a folder of results, found again.

use crate::files::RecordError;
use crate::report::ReportRun;
use crate::results::pareto::compare;
use crate::results::{ParamValue, RunRecord, SummaryRow};
use polars::prelude::{DataFrame, PlSmallStr};
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What was found below a folder.
#[derive(Debug)]
pub struct Records {
    /// The runs: in the order of `summary.csv` if it is there and names them, then by scenario, parameters and seed.
    pub runs: Vec<FoundRun>,
    /// Runs that these were compared with, in the order in which they are first needed.
    pub references: Vec<FoundRun>,
    /// What was passed over and why: files `run.json` of other programs, broken ones, folders that cannot be read.
    pub skipped: Vec<RecordError>,
}

/// A run whose record was found.
#[derive(Debug)]
pub struct FoundRun {
    /// Its record.
    pub record: RunRecord,
    /// `run.json`, and beside it `log.mcap` and `problems` if they are there.
    pub files: Vec<PathBuf>,
}

impl FoundRun {
    /// As a report shows it, with its row.
    pub fn reported<'a>(&'a self, row: &'a SummaryRow) -> ReportRun<'a> {
        let RunRecord { program, timing, notes, .. } = &self.record;
        ReportRun { row, program, machine: &timing.machine, notes, files: &self.files }
    }
}

/// Reads every `run.json` below a folder. Links to folders are not followed, and those whose names begin with a dot are
/// not looked into.
///
/// # Errors
/// The folder itself cannot be read.
pub fn read_records(folder: &Path) -> Result<Records, RecordError> {
    let (mut runs, mut references): (Vec<FoundRun>, Vec<FoundRun>) = Default::default();
    let skipped = walk(folder, &mut |is_reference, path, record| {
        if is_reference { &mut references } else { &mut runs }.push(FoundRun { record, files: files(path) });
    })?;
    let order = order(&folder.join("summary.csv"));
    runs.sort_by_cached_key(|run| Place::of(&run.record, &order));
    let needed: Vec<&str> = runs.iter().filter_map(|r| r.record.comparison.reference.as_deref()).collect();
    let place = |r: &FoundRun| needed.iter().position(|key| *key == r.record.key).unwrap_or(needed.len());
    references.sort_by_cached_key(place);
    Ok(Records { runs, references, skipped })
}

/// Tells of every record below a folder, and whether it is that of a reference, each run once; returns what was passed over.
pub(crate) fn walk(
    folder: &Path,
    tell: &mut dyn FnMut(bool, PathBuf, RunRecord),
) -> Result<Vec<RecordError>, RecordError> {
    let mut skipped = Vec::new();
    // An error about this folder alone is an error of the whole.
    std::fs::read_dir(folder).map_err(RecordError::io(folder))?;
    let mut seen: HashMap<Digest, Box<Path>> = HashMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let (own, below) = match entries(&folder) {
            Ok(found) => found,
            Err(error) => {
                skipped.push(error);
                continue;
            }
        };
        // The last is looked at next: in alphabetical order.
        folders.extend(below.into_iter().rev());
        let Some(path) = own else { continue };
        match RunRecord::read(&path) {
            Ok(record) => {
                let is_reference = is_reference(&path, &record);
                match seen.entry(digest(is_reference, &record.scenario, &record.key)) {
                    Entry::Occupied(other) => {
                        skipped.push(RecordError::Twice { path, other: other.get().to_path_buf() });
                    }
                    Entry::Vacant(free) => {
                        free.insert(path.clone().into_boxed_path());
                        tell(is_reference, path, record);
                    }
                }
            }
            Err(error) => skipped.push(error),
        }
    }
    Ok(skipped)
}

/// What stands for a run where there may be millions.
pub(crate) type Digest = [u8; 16];

/// Of a run, or of the reference of this key.
pub(crate) fn digest(is_reference: bool, scenario: &str, key: &str) -> Digest {
    let mut hasher = blake3::Hasher::new();
    // No name holds a zero.
    hasher.update(&[u8::from(is_reference)]).update(scenario.as_bytes()).update(&[0]).update(key.as_bytes());
    let mut digest = [0; 16];
    hasher.finalize_xof().fill(&mut digest);
    digest
}

/// References lie in `SCENARIO/references/KEY`, other runs in `SCENARIO/KEY`.
fn is_reference(path: &Path, record: &RunRecord) -> bool {
    let folder = |level: usize| path.ancestors().nth(level).and_then(Path::file_name);
    folder(2).is_some_and(|name| name == "references") && folder(3).is_some_and(|name| *name == *record.scenario)
}

/// The `run.json` of a folder, and the folders in it by name.
fn entries(folder: &Path) -> Result<(Option<PathBuf>, Vec<PathBuf>), RecordError> {
    let (mut own, mut below) = (None, Vec::new());
    for entry in std::fs::read_dir(folder).map_err(RecordError::io(folder))? {
        let entry = entry.map_err(RecordError::io(folder))?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        match entry.file_type().map_err(RecordError::io(&entry.path()))? {
            kind if kind.is_dir() => below.extend((!hidden).then(|| entry.path())),
            _ if entry.file_name() == "run.json" => own = Some(entry.path()),
            _ => {}
        }
    }
    below.sort();
    Ok((own, below))
}

pub(crate) fn files(record: PathBuf) -> Vec<PathBuf> {
    let beside = ["log.mcap", "problems"].map(|name| record.with_file_name(name));
    std::iter::once(record).chain(beside.into_iter().filter(|path| path.exists())).collect()
}

/// A run of which a report shows no more than its row and its files: without the texts that nobody looks at any more.
pub(crate) fn light(path: PathBuf, record: RunRecord) -> FoundRun {
    FoundRun { record: RunRecord { resolved: String::new(), inputs: Vec::new(), ..record }, files: files(path) }
}

/// Where the last summary has each run; empty if there is none, or it cannot be read: then it orders nothing.
pub(crate) fn order(summary: &Path) -> HashMap<Digest, u32> {
    let read = || {
        if !summary.is_file() {
            return Ok(DataFrame::empty());
        }
        let columns: Arc<[PlSmallStr]> = ["scenario".into(), "key".into()].into();
        let options = CsvReadOptions::default().with_infer_schema_length(Some(0)).with_columns(Some(columns));
        options.try_into_reader_with_file_path(Some(summary.to_owned()))?.finish()
    };
    let pairs = |frame: &DataFrame| -> Option<HashMap<Digest, u32>> {
        let (scenarios, keys) = (frame.column("scenario").ok()?.str().ok()?, frame.column("key").ok()?.str().ok()?);
        let rows = scenarios.iter().zip(keys.iter()).zip(0..);
        Some(rows.filter_map(|((scenario, key), row)| Some((digest(false, scenario?, key?), row))).collect())
    };
    read().ok().as_ref().and_then(pairs).unwrap_or_default()
}

/// What a run stands by that the last summary does not name: scenario, parameters, seed.
#[derive(PartialEq)]
pub(crate) struct Content {
    scenario: String,
    parameters: Vec<(String, ParamValue)>,
    seed: u64,
    key: String,
}

impl Content {
    pub fn of(record: &RunRecord) -> Self {
        let RunRecord { scenario, parameters, seed, key, .. } = record.clone();
        Content { scenario, parameters, seed, key }
    }
}

impl Eq for Content {}

impl Ord for Content {
    fn cmp(&self, other: &Self) -> Ordering {
        let parameters = || by_parameters(&self.parameters, &other.parameters);
        let rest = || self.seed.cmp(&other.seed).then_with(|| self.key.cmp(&other.key));
        self.scenario.cmp(&other.scenario).then_with(parameters).then_with(rest)
    }
}

impl PartialOrd for Content {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What a run is sorted by: its place in the last summary, else what it is.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Place {
    Row(u32),
    After(Box<Content>),
}

impl Place {
    pub fn of(record: &RunRecord, order: &HashMap<Digest, u32>) -> Self {
        match order.get(&digest(false, &record.scenario, &record.key)) {
            Some(row) => Place::Row(*row),
            None => Place::After(Box::new(Content::of(record))),
        }
    }
}

fn by_parameters(a: &[(String, ParamValue)], b: &[(String, ParamValue)]) -> Ordering {
    let mut orders = a.iter().zip(b).map(|((n, v), (m, w))| n.cmp(m).then_with(|| compare(Some(v), Some(w))));
    orders.find(|o| o.is_ne()).unwrap_or_else(|| a.len().cmp(&b.len()))
}
