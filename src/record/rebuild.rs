//! The records below a folder of results, found again.

use super::pareto::compare;
use super::{RecordError, ReportRun, RunRecord, SummaryRow};
use polars::prelude::DataFrame;
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

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
    let mut records = Records { runs: Vec::new(), references: Vec::new(), skipped: Vec::new() };
    // An error about this folder alone is an error of the whole.
    std::fs::read_dir(folder).map_err(RecordError::io(folder))?;
    let mut first: HashMap<(bool, String, String), PathBuf> = HashMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let (own, below) = match entries(&folder) {
            Ok(found) => found,
            Err(error) => {
                records.skipped.push(error);
                continue;
            }
        };
        // The last is looked at next: in alphabetical order.
        folders.extend(below.into_iter().rev());
        let Some(path) = own else { continue };
        match RunRecord::read(&path) {
            Ok(record) => {
                match first.entry((is_reference(&path, &record), record.scenario.clone(), record.key.clone())) {
                    std::collections::hash_map::Entry::Occupied(other) => {
                        records.skipped.push(RecordError::Twice { path, other: other.get().clone() });
                    }
                    std::collections::hash_map::Entry::Vacant(free) => {
                        free.insert(path.clone());
                        let kind =
                            if is_reference(&path, &record) { &mut records.references } else { &mut records.runs };
                        kind.push(FoundRun { record, files: files(path) });
                    }
                }
            }
            Err(error) => records.skipped.push(error),
        }
    }
    sort(&mut records.runs, &order(&folder.join("summary.csv")));
    let needed: Vec<&str> = records.runs.iter().filter_map(|r| r.record.comparison.reference.as_deref()).collect();
    let place = |r: &FoundRun| needed.iter().position(|key| *key == r.record.key).unwrap_or(needed.len());
    records.references.sort_by_cached_key(place);
    Ok(records)
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

pub(super) fn files(record: PathBuf) -> Vec<PathBuf> {
    let beside = ["log.mcap", "problems"].map(|name| record.with_file_name(name));
    std::iter::once(record).chain(beside.into_iter().filter(|path| path.exists())).collect()
}

/// Where the last summary has each run; empty if there is none, or it cannot be read: then it orders nothing.
fn order(summary: &Path) -> HashMap<(String, String), usize> {
    let read = || {
        if !summary.is_file() {
            return Ok(DataFrame::empty());
        }
        let options = CsvReadOptions::default().with_infer_schema_length(Some(0));
        options.try_into_reader_with_file_path(Some(summary.to_owned()))?.finish()
    };
    let pairs = |frame: &DataFrame| -> Option<HashMap<(String, String), usize>> {
        let (scenarios, keys) = (frame.column("scenario").ok()?.str().ok()?, frame.column("key").ok()?.str().ok()?);
        let rows = scenarios.iter().zip(keys.iter()).enumerate();
        Some(rows.filter_map(|(row, (scenario, key))| Some(((scenario?.to_owned(), key?.to_owned()), row))).collect())
    };
    read().ok().as_ref().and_then(pairs).unwrap_or_default()
}

fn sort(runs: &mut [FoundRun], order: &HashMap<(String, String), usize>) {
    let place = |r: &RunRecord| order.get(&(r.scenario.clone(), r.key.clone())).copied();
    let places: HashMap<PathBuf, Option<usize>> =
        runs.iter().map(|run| (run.files[0].clone(), place(&run.record))).collect();
    let by_content = |a: &RunRecord, b: &RunRecord| {
        let parameters = || by_parameters(a, b);
        let rest = || a.seed.cmp(&b.seed).then_with(|| a.key.cmp(&b.key));
        a.scenario.cmp(&b.scenario).then_with(parameters).then_with(rest)
    };
    runs.sort_by(|a, b| match (places[&a.files[0]], places[&b.files[0]]) {
        (Some(x), Some(y)) => x.cmp(&y),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => by_content(&a.record, &b.record),
    });
}

fn by_parameters(a: &RunRecord, b: &RunRecord) -> Ordering {
    let pairs = a.parameters.iter().zip(&b.parameters);
    let mut orders = pairs.map(|((n, v), (m, w))| n.cmp(m).then_with(|| compare(Some(v), Some(w))));
    orders.find(|o| o.is_ne()).unwrap_or_else(|| a.parameters.len().cmp(&b.parameters.len()))
}
