//! Detects two runs of the plan with one key, whose results would replace each other. Each shard
//! checks its own runs; of large plans it does not know the others.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use crate::merge::merge_error::MergeError;
use crate::merge::shards::Shards;
use crate::results::ShardRun;

/// Digests of all runs, 8 bytes each.
#[derive(Default)]
pub(super) struct Twins(Vec<u64>);

impl Twins {
    /// Adds the next run.
    pub fn add(&mut self, run: &ShardRun) {
        self.0.push(digest(run));
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.0.len()
    }

    /// Describes two runs with one key, if there are any.
    pub fn find(mut self, shards: &Shards) -> Result<Option<String>, MergeError> {
        self.0.sort_unstable();
        let Some(twin) = self.0.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]) else {
            return Ok(None);
        };
        let mut found: Vec<ShardRun> = Vec::new();
        shards.for_each_run(&mut |holders| {
            if digest(&holders[0].run) == twin {
                found.push(holders[0].run.clone());
            }
            Ok(())
        })?;
        let same = |a: &&ShardRun, b: &&ShardRun| (&a.scenario, &a.key) == (&b.scenario, &b.key);
        let pair = found.iter().zip(found.iter().skip(1)).find(|(a, b)| same(a, b));
        Ok(pair.map(|(a, b)| {
            format!("runs {} and {} of the plan are the same: {} {}", a.at + 1, b.at + 1, a.scenario, a.key)
        }))
    }
}

fn digest(run: &ShardRun) -> u64 {
    let mut hasher = DefaultHasher::new();
    (&run.scenario, &run.key).hash(&mut hasher);
    hasher.finish()
}
