//! What is found when every run of every shard is looked at.

use crate::results::RunRecord;
use crate::results::merge::walk::{Found, Holder, difference};
use crate::results::merge::{MOST_NAMED, MergeError};
use std::collections::BTreeSet;

/// What was found so far. Of runs with the same trouble only the first are named, so that this stays small.
pub(super) struct Look {
    /// By shard, the runs of which it has no result.
    pub absent: Vec<Lost>,
    /// Shards and places of what is there and is no result to take.
    pub broken: BTreeSet<(usize, usize)>,
    /// Runs that left a log, and runs that left none.
    pub with_log: usize,
    pub without_log: usize,
    differ: Vec<String>,
    differing: usize,
}

/// Runs of a shard of which it has no result.
#[derive(Clone, Default)]
pub(super) struct Lost {
    count: usize,
    first: Vec<String>,
}

impl Look {
    pub fn new(shards: usize) -> Self {
        Look {
            absent: vec![Lost::default(); shards],
            broken: BTreeSet::new(),
            with_log: 0,
            without_log: 0,
            differ: Vec::new(),
            differing: 0,
        }
    }

    /// Looks at a run wherever it is; returns the first that has it whole.
    pub fn at<'a, 'b>(&mut self, holders: &'a [Holder<'b>]) -> Option<(&'a Holder<'b>, Box<RunRecord>)> {
        let run = &holders[0].run;
        let mut first: Option<(&Holder, Box<RunRecord>)> = None;
        for holder in holders {
            match holder.find() {
                Found::Absent => self.absent[holder.shard].add(|| format!("{} {}", run.scenario, run.key)),
                Found::Broken(why) => {
                    self.broken.insert((holder.shard, run.at));
                    self.absent[holder.shard].add(|| format!("{} {} ({why})", run.scenario, run.key));
                }
                Found::Whole(record) => match &first {
                    None => {
                        *if holder.log().exists() { &mut self.with_log } else { &mut self.without_log } += 1;
                        first = Some((holder, record));
                    }
                    Some((other, known)) => {
                        if let Some(what) = difference(other, known, holder, &record) {
                            self.differing += 1;
                            if self.differ.len() < MOST_NAMED {
                                self.differ.push(what);
                            }
                        }
                    }
                },
            }
        }
        first
    }

    /// Itself, if what several shards have is the same.
    pub fn same(mut self) -> Result<Self, MergeError> {
        if self.differing == 0 {
            return Ok(self);
        }
        self.differ.insert(0, format!("{} runs are in several folders and differ:", self.differing));
        Err(MergeError::Runs(self.differ))
    }
}

impl Lost {
    fn add(&mut self, what: impl FnOnce() -> String) {
        self.count += 1;
        if self.first.len() < MOST_NAMED {
            self.first.push(what());
        }
    }

    /// In words, if there is any.
    pub fn line(&self, shard: &str) -> Option<String> {
        let (words, dots) = (self.first.join(", "), if self.count > MOST_NAMED { ", ..." } else { "" });
        (self.count > 0).then(|| {
            format!("{shard} has no result of {} of its runs: {words}{dots}; run it again with --resume", self.count)
        })
    }
}
