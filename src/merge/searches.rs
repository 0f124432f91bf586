//! The results of searches in all shards. Each shard has the searches of its own cells.

use crate::merge::shards::Shards;
use crate::results::ShardHead;
use crate::results::searches::{SearchResult, SearchVerdict};
use std::collections::BTreeMap;

impl Shards {
    /// The heads of the shards, each once: of several copies of a shard the one that is furthest.
    fn distinct_heads(&self) -> Vec<(usize, &ShardHead)> {
        let mut known: BTreeMap<u64, (usize, &ShardHead)> = BTreeMap::new();
        let open = |head: &ShardHead| {
            let is_open = |search: &&SearchResult| search.verdict == SearchVerdict::Unfinished;
            (head.searches.is_empty(), head.searches.iter().filter(is_open).count())
        };
        for (shard, head) in self.heads.iter().enumerate() {
            let entry = known.entry(head.shard).or_insert((shard, head));
            if open(head) < open(entry.1) {
                *entry = (shard, head);
            }
        }
        known.into_values().collect()
    }

    /// Number of planned runs that no search has chosen.
    pub(super) fn unused(&self) -> usize {
        self.distinct_heads().iter().map(|(_, head)| head.unused).sum()
    }

    /// The results of all searches, in the order of the plan.
    pub(super) fn searches(&self) -> Vec<SearchResult> {
        let heads = self.distinct_heads();
        let mut all: Vec<SearchResult> = heads.into_iter().flat_map(|(_, head)| head.searches.clone()).collect();
        // Scenarios in the order of the plan, which all shards share.
        let mut order: Vec<String> = Vec::new();
        for search in &all {
            if !order.contains(&search.scenario) {
                order.push(search.scenario.clone());
            }
        }
        all.sort_by_key(|search| (order.iter().position(|scenario| *scenario == search.scenario), search.cell));
        all
    }

    /// A line for each shard whose searches are not at their ends.
    pub(super) fn unfinished_searches(&self) -> Vec<String> {
        let of = |(shard, head): (usize, &ShardHead)| {
            let is_open = |search: &&SearchResult| search.verdict == SearchVerdict::Unfinished;
            let name = self.name(shard);
            match head.searches.iter().filter(is_open).count() {
                0 if head.searches.is_empty() && head.unused > 0 => {
                    Some(format!("{name} has not ended its searches; run it again with --resume"))
                }
                0 => None,
                n => Some(format!("{name} has not ended {n} of its searches; run it again with --resume")),
            }
        };
        self.distinct_heads().into_iter().filter_map(of).collect()
    }
}
