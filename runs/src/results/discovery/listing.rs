//! A listing of the records below a folder of results: a few hundred bytes for each run,
//! independent of the length of its record.

use super::records::{FoundRun, for_each_record};
use super::run_order::{SortKey, summary_order};
use crate::files::{RecordError, modified, names};
use crate::results::{BoundedSample, Rows, RunRecord, RunStatistics, SummaryRow};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Paths of the records below a folder, in the order of [`Records`](crate::results::Records).
#[derive(Debug)]
pub struct Listing {
    runs: Vec<ListedRun>,
    /// Reference runs, in the order in which the runs first need them.
    pub references: Vec<FoundRun>,
    /// Errors of files and folders that were skipped.
    pub skipped: Vec<RecordError>,
}

#[derive(Debug)]
struct ListedRun {
    record: Box<Path>,
    scenario: Arc<str>,
    key: Box<str>,
}

/// Statistics of all runs and a sample of them.
#[derive(Debug, Default)]
pub struct SampledRuns {
    /// Statistics of all runs.
    pub statistics: RunStatistics,
    /// A bounded sample, and the runs selected in [`Listing::rows`].
    pub runs: Vec<FoundRun>,
}

/// Lists every `run.json` below a folder; finds the same ones as
/// [`read_records`](crate::results::read_records).
///
/// # Errors
/// The folder itself cannot be read.
pub fn list_records(folder: &Path) -> Result<Listing, RecordError> {
    let order = summary_order(&folder.join(names::SUMMARY_CSV));
    let (mut runs, mut references, mut needed) = (Vec::new(), Vec::new(), HashMap::new());
    let mut scenarios: BTreeSet<Arc<str>> = BTreeSet::new();
    let skipped = for_each_record(folder, &mut |is_reference, path, record| {
        if is_reference {
            references.push(FoundRun::without_inputs(path, record));
            return;
        }
        let sort_key = SortKey::of(&record, &order);
        let reference = record.comparison.reference.map(|key| {
            let next = needed.len();
            *needed.entry(key).or_insert(next)
        });
        let scenario = scenarios.get(record.scenario.as_str()).cloned().unwrap_or_else(|| {
            let new: Arc<str> = record.scenario.as_str().into();
            scenarios.insert(new.clone());
            new
        });
        let run = ListedRun { record: path.into_boxed_path(), scenario, key: record.key.into_boxed_str() };
        runs.push((sort_key, reference, run));
    })?;
    runs.sort_by(|a, b| a.0.cmp(&b.0));
    // The first run that needs a reference, in this order, gives its position.
    let mut first = vec![usize::MAX; needed.len()];
    for (at, (_, reference, _)) in runs.iter().enumerate() {
        if let Some(reference) = reference {
            first[*reference] = first[*reference].min(at);
        }
    }
    references.sort_by_cached_key(|r: &FoundRun| needed.get(&r.record.key).map_or(usize::MAX, |number| first[*number]));
    Ok(Listing { runs: runs.into_iter().map(|(_, _, run)| run).collect(), references, skipped })
}

impl Listing {
    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }

    /// Positions of the runs whose keys begin with a prefix.
    pub fn with_key_prefix<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = usize> + 'a {
        let all = self.runs.iter().enumerate();
        all.filter(move |(_, run)| run.key.starts_with(prefix)).map(|(position, _)| position)
    }

    /// The scenario of the run at a position.
    pub fn scenario(&self, position: usize) -> &str {
        &self.runs[position].scenario
    }

    /// Key of the run at a position, and its log if there is one.
    pub fn key_and_log(&self, position: usize) -> (&str, Option<PathBuf>) {
        let run = &self.runs[position];
        (&run.key, Some(run.record.with_file_name(names::LOG)).filter(|log| log.exists()))
    }

    /// Rows of all runs, read one by one on each pass. The first pass also gathers statistics, a
    /// bounded sample, and the runs at the selected positions.
    pub fn rows(&self, selected: &[usize]) -> ListedRows<'_> {
        ListedRows { listing: self, selected: selected.iter().copied().collect(), sampled: RefCell::default() }
    }
}

/// Rows of the runs of a [`Listing`].
pub struct ListedRows<'a> {
    listing: &'a Listing,
    selected: BTreeSet<usize>,
    sampled: RefCell<Option<SampledRuns>>,
}

impl ListedRows<'_> {
    /// Statistics and sample of the first pass; empty before it.
    pub fn into_sampled(self) -> SampledRuns {
        self.sampled.into_inner().unwrap_or_default()
    }
}

impl Rows for ListedRows<'_> {
    fn for_each(&self, visit: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        let is_first = self.sampled.borrow().is_none();
        let (mut statistics, mut sample) = (RunStatistics::default(), BoundedSample::default());
        let mut selected = BTreeMap::new();
        for (position, run) in self.listing.runs.iter().enumerate() {
            let record = RunRecord::read(&run.record)?;
            let row = record.summary_row();
            visit(&row)?;
            if is_first {
                statistics.add(&row, Some((&record.program, &record.timing.machine)), modified(&run.record));
                let found = FoundRun::without_inputs(run.record.to_path_buf(), record);
                match self.selected.contains(&position) {
                    true => _ = selected.insert(position, found),
                    false => sample.insert(position, (position, found), row.is_refused()),
                }
            }
        }
        if is_first {
            selected.extend(sample.into_sorted());
            self.sampled.replace(Some(SampledRuns { statistics, runs: selected.into_values().collect() }));
        }
        Ok(())
    }
}
