//! Visits the runs of all shards in the order of the plan, by merging their sorted lists.

use crate::files::RecordError;
use crate::files::names;
use crate::merge::merge_error::MergeError;
use crate::merge::shards::Shards;
use crate::results::{RunRecord, SHARD_LIST, ShardList, ShardRun, log_mismatch};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::{Path, PathBuf};

/// A run as listed by one shard.
pub(super) struct Holder<'a> {
    pub shard: usize,
    pub folder: &'a Path,
    pub run: ShardRun,
}

/// Result of a run in a shard.
pub(super) enum ShardResult {
    /// The record, with its log if it has one.
    Whole(Box<RunRecord>),
    /// No record.
    Absent,
    /// An unusable result, with the reason.
    Broken(&'static str),
}

impl Holder<'_> {
    /// Checks the result of the run.
    pub fn result(&self) -> ShardResult {
        if !self.record().exists() {
            return ShardResult::Absent;
        }
        let Ok(record) = RunRecord::read(&self.record()) else {
            return ShardResult::Broken("its record is incomplete");
        };
        if (&record.scenario, &record.key) != (&self.run.scenario, &self.run.key) {
            return ShardResult::Broken("its record belongs to another run");
        }
        match log_mismatch(&record, &self.log()) {
            Some(fault) => ShardResult::Broken(fault.reason()),
            None => ShardResult::Whole(Box::new(record)),
        }
    }

    pub fn log(&self) -> PathBuf {
        self.record().with_file_name(names::LOG)
    }

    pub fn record(&self) -> PathBuf {
        self.run.folder(self.folder).join(names::RUN_RECORD)
    }
}

impl Shards {
    /// Calls `visit` for each listed run, with all shards that list it.
    pub(super) fn for_each_run(
        &self,
        visit: &mut dyn FnMut(&[Holder]) -> Result<(), MergeError>,
    ) -> Result<(), MergeError> {
        let mut lists = self.folders.iter().map(|f| ShardList::open(f)).collect::<Result<Vec<_>, RecordError>>()?;
        let changed = lists.iter().zip(&self.heads).position(|(list, head)| list.head != *head);
        if let Some(shard) = changed {
            let what = format!("its {SHARD_LIST} is another one");
            return Err(MergeError::Changed { path: self.folders[shard].clone(), what });
        }
        let mut waiting: Vec<Option<ShardRun>> = Vec::new();
        let mut next = BinaryHeap::new();
        for (shard, list) in lists.iter_mut().enumerate() {
            let run = list.next().transpose()?;
            next.extend(run.as_ref().map(|run| Reverse((run.at, shard))));
            waiting.push(run);
        }
        while let Some(&Reverse((at, _))) = next.peek() {
            let mut holders = Vec::new();
            while let Some(&Reverse((_, shard))) = next.peek().filter(|Reverse((other, _))| *other == at) {
                next.pop();
                if let Some(run) = waiting[shard].take() {
                    holders.push(Holder { shard, folder: &self.folders[shard], run });
                }
                waiting[shard] = lists[shard].next().transpose()?;
                if let Some(run) = &waiting[shard] {
                    if run.at <= at {
                        let what = format!("{}: the list is not sorted", self.folders[shard].display());
                        return Err(MergeError::Runs(vec![what]));
                    }
                    next.push(Reverse((run.at, shard)));
                }
            }
            visit(&holders)?;
        }
        Ok(())
    }
}
