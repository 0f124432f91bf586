//! References that runs of the plan need: each once, from the shard of the first run that needs it.

use crate::results::RunRecord;
use crate::results::merge::walk::{Holder, comparable, first_difference};
use crate::results::merge::{MOST_NAMED, MergeError, Shards};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A reference: the shard and the scenario of the first run that needs it.
#[derive(Debug)]
pub(super) struct Needed {
    pub shard: usize,
    scenario: String,
    key: String,
    is_whole: bool,
}

impl Needed {
    /// Its folder, below that of results.
    pub fn below(&self) -> PathBuf {
        below(&self.scenario, &self.key)
    }
}

fn below(scenario: &str, key: &str) -> PathBuf {
    Path::new(scenario).join("references").join(key)
}

/// The references found so far, in the order in which they are first needed.
#[derive(Debug, Default)]
pub(super) struct References {
    places: BTreeMap<String, usize>,
    needed: Vec<Needed>,
    seen: BTreeSet<(usize, usize)>,
    wrong: Vec<String>,
}

impl References {
    /// Notes that of a run. Its shard has made it too, under the scenario of its own first run that needs it.
    pub fn note(&mut self, shards: &Shards, holder: &Holder, record: &RunRecord) {
        let Some(key) = &record.comparison.reference else { return };
        let read = |shard: usize, scenario: &str| {
            let path = shards.folders[shard].join(below(scenario, key)).join("run.json");
            RunRecord::read(&path).ok().filter(|record| record.key == *key)
        };
        let Some(&place) = self.places.get(key) else {
            let (shard, scenario) = (holder.shard, holder.run.scenario.clone());
            let is_whole = read(shard, &scenario).is_some();
            self.places.insert(key.clone(), self.needed.len());
            self.seen.insert((shard, self.needed.len()));
            self.needed.push(Needed { shard, scenario, key: key.clone(), is_whole });
            return;
        };
        if !self.seen.insert((holder.shard, place)) {
            return;
        }
        let first = &self.needed[place];
        let values = |shard, scenario: &str| {
            read(shard, scenario).map(|mut record| {
                record.scenario.clear();
                comparable(&record)
            })
        };
        let pair = (values(first.shard, &first.scenario), values(holder.shard, &holder.run.scenario));
        if let (Some(a), Some(b)) = pair
            && let Some(what) = first_difference("", &a, &b)
        {
            let (a, b) = (shards.folders[first.shard].display(), shards.folders[holder.shard].display());
            self.wrong.push(format!("reference {key}: {what} in {a} and {b}"));
        }
    }

    /// Itself, if what several shards have is the same.
    pub fn same(mut self) -> Result<Self, MergeError> {
        if self.wrong.is_empty() {
            return Ok(self);
        }
        self.wrong.truncate(MOST_NAMED);
        self.wrong.insert(0, "the shards were made by machines or programs that do not give the same bits:".into());
        Err(MergeError::Runs(self.wrong))
    }

    /// Those whose record is there.
    pub fn whole(&self) -> impl Iterator<Item = &Needed> {
        self.needed.iter().filter(|needed| needed.is_whole)
    }

    /// The others, in words.
    pub fn lost(&self, shards: &Shards) -> impl Iterator<Item = String> {
        let lost = self.needed.iter().filter(|needed| !needed.is_whole);
        lost.take(MOST_NAMED).map(|needed| {
            let (shard, Needed { scenario, key, .. }) = (shards.name(needed.shard), needed);
            format!("{shard} has no whole record of reference {key} of {scenario}; run it again with --resume")
        })
    }
}
