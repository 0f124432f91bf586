//! Stores finished runs: a few thousand in memory, the others in their records.

use crate::files::names;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use crate::batch::{Finished, Job, Plan};
use crate::files::{RecordError, modified};
use crate::results::{BoundedSample, Machine, PROGRAM, Rows, RunRecord, RunStatistics, SummaryColumns, SummaryRow};
use crate::sim::Outcome;

/// Finished runs by their positions in the plan.
#[derive(Debug, Default)]
pub(in crate::batch) struct Store {
    sample: BoundedSample<Finished>,
    /// Runs without a record, which exist only in memory.
    unwritten: BTreeMap<usize, Finished>,
    done: Vec<bool>,
    /// Number of finished runs.
    pub count: usize,
    /// Number of runs that were not accepted, failed expectations excluded.
    pub unfinished: usize,
    /// Number of runs with a failed expectation.
    pub failed: usize,
}

impl Store {
    /// Adds a finished run.
    pub fn insert(&mut self, index: usize, finished: Finished) {
        if self.done.len() <= index {
            self.done.resize(index + 1, false);
        }
        self.done[index] = true;
        self.count += 1;
        let is_written = finished.files.iter().any(|file| file.ends_with(names::RUN_RECORD));
        match finished.row.outcome {
            Outcome::Failed => self.failed += 1,
            _ if !finished.accepted => self.unfinished += 1,
            _ => {}
        }
        if is_written {
            let is_refused = !finished.accepted;
            self.sample.insert(index, finished, is_refused);
        } else {
            self.unwritten.insert(index, finished);
        }
    }

    pub fn is_done(&self, index: usize) -> bool {
        self.done.get(index).copied().unwrap_or(false)
    }

    /// Positions of all finished runs.
    pub fn positions(&self) -> impl Iterator<Item = usize> {
        self.done.iter().enumerate().filter(|(_, done)| **done).map(|(index, _)| index)
    }

    /// A finished run, if it is in memory.
    pub fn get_mut(&mut self, index: usize) -> Option<&mut Finished> {
        self.unwritten.get_mut(&index).or_else(|| self.sample.get_mut(index))
    }

    /// The row of a finished run, from memory or from its record.
    ///
    /// # Errors
    /// The record cannot be read.
    pub fn row(&self, index: usize, plan: &Plan, output: &Path) -> Result<Cow<'_, SummaryRow>, RecordError> {
        match self.in_memory(index) {
            Some(finished) => Ok(Cow::Borrowed(&finished.row)),
            None => {
                let record = RunRecord::read(&plan.folder(index, output).join(names::RUN_RECORD))?;
                Ok(Cow::Owned(record.summary_row()))
            }
        }
    }

    fn in_memory(&self, index: usize) -> Option<&Finished> {
        self.unwritten.get(&index).or_else(|| self.sample.get(index))
    }

    /// A finished run, from memory or from its record.
    ///
    /// # Errors
    /// The record cannot be read.
    pub fn finished(&self, job: &Job, output: &Path) -> Result<Finished, RecordError> {
        if let Some(finished) = self.in_memory(job.index) {
            return Ok(finished.clone());
        }
        let path = job.folder(output).join(names::RUN_RECORD);
        let record = RunRecord::read(&path)?;
        let row = record.summary_row();
        let (recorded, accepted) = (modified(&path), !row.is_refused());
        Ok(Finished { files: vec![path], recorded, notes: record.notes, accepted, row, storage_full: false })
    }

    /// The runs in memory that a report shows, in the order of the plan.
    pub fn shown(&self) -> Vec<&Finished> {
        let mut shown = BoundedSample::default();
        let unwritten = self.unwritten.iter().map(|(index, finished)| (*index, finished));
        for (index, finished) in self.sample.iter().chain(unwritten) {
            shown.insert(index, finished, !finished.accepted);
        }
        shown.into_sorted()
    }

    /// The runs of [`Store::shown`].
    pub fn into_shown(self) -> Vec<Finished> {
        let Store { mut sample, unwritten, .. } = self;
        for (index, finished) in unwritten {
            let is_refused = !finished.accepted;
            sample.insert(index, finished, is_refused);
        }
        sample.into_sorted()
    }
}

/// The rows of all finished runs, in the order of the plan.
pub(in crate::batch) struct AllRows<'a> {
    pub store: &'a Store,
    pub plan: &'a Plan,
    pub output: &'a Path,
}

impl AllRows<'_> {
    /// The columns of the summary, and statistics; sums follow the order of the plan.
    pub fn survey(&self) -> Result<(SummaryColumns, RunStatistics), RecordError> {
        let (mut columns, mut statistics) = (SummaryColumns::default(), RunStatistics::default());
        let machine = Machine::here();
        for index in self.store.positions() {
            let row = self.store.row(index, self.plan, self.output)?;
            let recorded = match self.store.in_memory(index) {
                Some(finished) => finished.recorded,
                None => modified(&self.plan.folder(index, self.output).join(names::RUN_RECORD)),
            };
            columns.add(&row);
            statistics.add(&row, Some((PROGRAM, &machine)), recorded);
        }
        Ok((columns, statistics))
    }
}

impl Rows for AllRows<'_> {
    fn for_each(&self, visit: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        self.store.positions().try_for_each(|index| visit(&*self.store.row(index, self.plan, self.output)?))
    }
}
