//! Checks every run of every shard: present, whole, and equal in all shards that have it.

use crate::merge::merge_error::{MAX_NAMED, MergeError};
use crate::merge::plan_walk::{Holder, ShardResult};
use crate::merge::record_difference::difference;
use crate::results::RunRecord;
use std::collections::BTreeSet;

/// Findings so far. Only the first runs of each problem are named, to bound memory.
pub(super) struct ShardCheck {
    /// Runs without a result, by shard.
    pub absent: Vec<MissingRuns>,
    /// Shard and plan index of unusable results.
    pub broken: BTreeSet<(usize, usize)>,
    /// Plan indices of runs of which no shard has a whole result.
    pub without_result: BTreeSet<usize>,
    /// Number of runs with a log.
    pub with_log: usize,
    /// Number of runs without a log.
    pub without_log: usize,
    differ: Vec<String>,
    differing: usize,
}

/// Runs of a shard without a result.
#[derive(Clone, Default)]
pub(super) struct MissingRuns {
    count: usize,
    first: Vec<String>,
}

impl ShardCheck {
    pub fn new(shards: usize) -> Self {
        ShardCheck {
            absent: vec![MissingRuns::default(); shards],
            broken: BTreeSet::new(),
            without_result: BTreeSet::new(),
            with_log: 0,
            without_log: 0,
            differ: Vec::new(),
            differing: 0,
        }
    }

    /// Checks a run in all shards that list it; returns the first whole result.
    pub fn check<'a, 'b>(&mut self, holders: &'a [Holder<'b>]) -> Option<(&'a Holder<'b>, Box<RunRecord>)> {
        let run = &holders[0].run;
        let mut first: Option<(&Holder, Box<RunRecord>)> = None;
        for holder in holders {
            match holder.result() {
                ShardResult::Absent => self.absent[holder.shard].add(|| format!("{} {}", run.scenario, run.key)),
                ShardResult::Broken(why) => {
                    self.broken.insert((holder.shard, run.at));
                    self.absent[holder.shard].add(|| format!("{} {} ({why})", run.scenario, run.key));
                }
                ShardResult::Whole(record) => match &first {
                    None => {
                        *if holder.log().exists() { &mut self.with_log } else { &mut self.without_log } += 1;
                        first = Some((holder, record));
                    }
                    Some((other, known)) => {
                        if let Some(what) = difference(other, known, holder, &record) {
                            self.differing += 1;
                            if self.differ.len() < MAX_NAMED {
                                self.differ.push(what);
                            }
                        }
                    }
                },
            }
        }
        if first.is_none() {
            self.without_result.insert(run.at);
        }
        first
    }

    /// An error if results of one run differ between shards.
    pub fn require_equal(mut self) -> Result<Self, MergeError> {
        if self.differing == 0 {
            return Ok(self);
        }
        self.differ.insert(0, format!("{} runs differ between folders:", self.differing));
        Err(MergeError::Runs(self.differ))
    }
}

impl MissingRuns {
    fn add(&mut self, what: impl FnOnce() -> String) {
        self.count += 1;
        if self.first.len() < MAX_NAMED {
            self.first.push(what());
        }
    }

    /// A line of text; none if no run is missing.
    pub fn line(&self, shard: &str) -> Option<String> {
        let (first, dots) = (self.first.join(", "), if self.count > MAX_NAMED { ", ..." } else { "" });
        (self.count > 0).then(|| {
            format!("{shard} has no result of {} of its runs: {first}{dots}; run it again with --resume", self.count)
        })
    }
}
