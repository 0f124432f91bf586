//! The records below a folder of results by their places alone: a few hundred bytes for each run, however much they hold.

use crate::files::RecordError;
use crate::results::rebuild::{self, FoundRun, Place};
use crate::results::{Kept, Rows, RunRecord, SummaryRow, Tally};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// What was found below a folder, in the order of [`Records`](crate::results::Records).
#[derive(Debug)]
pub struct Listing {
    runs: Vec<Entry>,
    /// Runs that these were compared with, in the order in which they are first needed.
    pub references: Vec<FoundRun>,
    /// What was passed over and why.
    pub skipped: Vec<RecordError>,
}

/// A run that was found.
#[derive(Debug)]
struct Entry {
    record: Box<Path>,
    key: Box<str>,
}

/// What can be said of all runs after each was looked at once.
#[derive(Debug, Default)]
pub struct Seen {
    /// Numbers of them.
    pub tally: Tally,
    /// As many as are shown, and those that were asked for.
    pub runs: Vec<FoundRun>,
}

/// Looks for every `run.json` below a folder as [`read_records`](crate::results::read_records) does, and keeps where they are.
///
/// # Errors
/// The folder itself cannot be read.
pub fn list_records(folder: &Path) -> Result<Listing, RecordError> {
    let order = rebuild::order(&folder.join("summary.csv"));
    let (mut runs, mut references, mut needed) = (Vec::new(), Vec::new(), HashMap::new());
    let skipped = rebuild::walk(folder, &mut |is_reference, path, record| {
        if is_reference {
            references.push(rebuild::light(path, record));
            return;
        }
        let place = Place::of(&record, &order);
        let reference = record.comparison.reference.map(|key| {
            let next = needed.len();
            *needed.entry(key).or_insert(next)
        });
        let entry = Entry { record: path.into_boxed_path(), key: record.key.into_boxed_str() };
        runs.push((place, reference, entry));
    })?;
    runs.sort_by(|a, b| a.0.cmp(&b.0));
    // The first run that needs a reference, in this order, says where that stands.
    let mut first = vec![usize::MAX; needed.len()];
    for (at, (_, reference, _)) in runs.iter().enumerate() {
        if let Some(reference) = reference {
            first[*reference] = first[*reference].min(at);
        }
    }
    references.sort_by_cached_key(|r: &FoundRun| needed.get(&r.record.key).map_or(usize::MAX, |number| first[*number]));
    Ok(Listing { runs: runs.into_iter().map(|(_, _, entry)| entry).collect(), references, skipped })
}

impl Listing {
    /// How many runs.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }

    /// Places of the runs whose keys begin like this.
    pub fn named<'a>(&'a self, beginning: &'a str) -> impl Iterator<Item = usize> + 'a {
        let all = self.runs.iter().enumerate();
        all.filter(move |(_, entry)| entry.key.starts_with(beginning)).map(|(place, _)| place)
    }

    /// The scenario of the run at a place, as its folder says; empty if there is none to say so.
    pub fn scenario(&self, place: usize) -> String {
        let folder = self.runs[place].record.ancestors().nth(2).and_then(Path::file_name);
        folder.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Key and log of the run at a place, this if it is there.
    pub fn key_and_log(&self, place: usize) -> (&str, Option<PathBuf>) {
        let entry = &self.runs[place];
        (&entry.key, Some(entry.record.with_file_name("log.mcap")).filter(|log| log.exists()))
    }

    /// The rows of all runs, read one by one each time. The first time they are counted, and those to be shown are kept: as
    /// many as there is room for, and those at the places asked for.
    pub fn rows(&self, asked: &[usize]) -> ListedRows<'_> {
        ListedRows { listing: self, asked: asked.iter().copied().collect(), seen: RefCell::default() }
    }
}

/// See [`Listing::rows`].
pub struct ListedRows<'a> {
    listing: &'a Listing,
    asked: BTreeSet<usize>,
    seen: RefCell<Option<Seen>>,
}

impl ListedRows<'_> {
    /// What was seen; nothing before the rows were gone through.
    pub fn into_seen(self) -> Seen {
        self.seen.into_inner().unwrap_or_default()
    }
}

impl Rows for ListedRows<'_> {
    fn each(&self, tell: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        let is_first = self.seen.borrow().is_none();
        let (mut tally, mut kept, mut asked) = (Tally::default(), Kept::default(), BTreeMap::new());
        for (place, entry) in self.listing.runs.iter().enumerate() {
            let record = RunRecord::read(&entry.record)?;
            let row = record.summary_row();
            tell(&row)?;
            if is_first {
                tally.add(&row, &record.program, &record.timing.machine, Some(&entry.record));
                let found = rebuild::light(entry.record.to_path_buf(), record);
                match self.asked.contains(&place) {
                    true => _ = asked.insert(place, found),
                    false => kept.insert(place, (place, found), row.is_refused()),
                }
            }
        }
        if is_first {
            asked.extend(kept.into_sorted());
            self.seen.replace(Some(Seen { tally, runs: asked.into_values().collect() }));
        }
        Ok(())
    }
}
