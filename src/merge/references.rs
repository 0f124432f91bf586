//! Reference runs of the plan: each once, from the shard of the first run that needs it.

use crate::files::{KeyLevels, names};
use crate::merge::merge_error::{MAX_NAMED, MergeError};
use crate::merge::plan_walk::Holder;
use crate::merge::record_difference::{comparable, first_difference};
use crate::merge::shards::Shards;
use crate::results::RunRecord;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A reference run, with the shard and scenario of the first run that needs it.
#[derive(Debug)]
pub(super) struct NeededReference {
    pub shard: usize,
    scenario: String,
    levels: KeyLevels,
    key: String,
    is_whole: bool,
}

impl NeededReference {
    /// Its folder, relative to the folder of results.
    pub fn folder(&self) -> PathBuf {
        reference_folder(&self.scenario, self.levels, &self.key)
    }
}

fn reference_folder(scenario: &str, levels: KeyLevels, key: &str) -> PathBuf {
    Path::new(scenario).join(names::REFERENCES).join(levels.folder(key))
}

/// Reference runs found so far, in the order in which the runs first need them.
#[derive(Debug, Default)]
pub(super) struct References {
    positions: BTreeMap<String, usize>,
    needed: Vec<NeededReference>,
    checked: BTreeSet<(usize, usize)>,
    differences: Vec<String>,
}

impl References {
    /// Adds the reference of a run. Each shard has its own copy, under the scenario of its first
    /// run that needs it.
    pub fn add(&mut self, shards: &Shards, holder: &Holder, record: &RunRecord) {
        let Some(key) = &record.comparison.reference else { return };
        let read = |shard: usize, scenario: &str, levels: KeyLevels| {
            let path = shards.folders[shard].join(reference_folder(scenario, levels, key)).join(names::RUN_RECORD);
            RunRecord::read(&path).ok().filter(|record| record.key == *key)
        };
        let Some(&position) = self.positions.get(key) else {
            let (shard, scenario, levels) = (holder.shard, holder.run.scenario.clone(), holder.run.levels);
            let is_whole = read(shard, &scenario, levels).is_some();
            self.positions.insert(key.clone(), self.needed.len());
            self.checked.insert((shard, self.needed.len()));
            self.needed.push(NeededReference { shard, scenario, levels, key: key.clone(), is_whole });
            return;
        };
        if !self.checked.insert((holder.shard, position)) {
            return;
        }
        let first = &self.needed[position];
        let values = |shard, scenario: &str, levels| {
            read(shard, scenario, levels).map(|mut record| {
                record.scenario.clear();
                comparable(&record)
            })
        };
        let pair = (
            values(first.shard, &first.scenario, first.levels),
            values(holder.shard, &holder.run.scenario, holder.run.levels),
        );
        if let (Some(a), Some(b)) = pair
            && let Some(what) = first_difference("", &a, &b)
        {
            let (a, b) = (shards.folders[first.shard].display(), shards.folders[holder.shard].display());
            self.differences.push(format!("reference {key}: {what} in {a} and {b}"));
        }
    }

    /// An error if a reference differs between shards.
    pub fn require_equal(mut self) -> Result<Self, MergeError> {
        if self.differences.is_empty() {
            return Ok(self);
        }
        self.differences.truncate(MAX_NAMED);
        self.differences.insert(0, "the machines or programs of the shards do not compute the same bits:".into());
        Err(MergeError::Runs(self.differences))
    }

    /// References with a whole record.
    pub fn whole(&self) -> impl Iterator<Item = &NeededReference> {
        self.needed.iter().filter(|needed| needed.is_whole)
    }

    /// Lines of text about the other references.
    pub fn missing(&self, shards: &Shards) -> impl Iterator<Item = String> {
        let missing = self.needed.iter().filter(|needed| !needed.is_whole);
        missing.take(MAX_NAMED).map(|needed| {
            let (shard, NeededReference { scenario, key, .. }) = (shards.name(needed.shard), needed);
            format!("{shard} has no complete record of reference {key} of {scenario}; run it again with --resume")
        })
    }
}
