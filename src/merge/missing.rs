//! Checks that the shards have every run of the plan.

use crate::merge::merge_error::{MAX_NAMED, MergeError};
use crate::merge::missing_logs::missing_logs;
use crate::merge::plan_walk::Holder;
use crate::merge::references::References;
use crate::merge::shard_check::ShardCheck;
use crate::merge::shards::Shards;
use crate::merge::twins::Twins;
use crate::results::SHARD_LIST;
use std::collections::BTreeSet;

/// Missing parts of the results.
#[derive(Debug)]
pub struct Missing {
    /// One line of text each; empty when nothing is missing.
    pub lines: Vec<String>,
    /// Shard and plan index of unusable results.
    pub(super) broken: BTreeSet<(usize, usize)>,
    /// Plan indices of runs of which no shard has a whole result.
    pub(super) without_result: BTreeSet<usize>,
    pub(super) references: References,
}

impl Shards {
    /// Checks that every run is present, whole, and equal in all shards that have it; returns what
    /// is missing.
    ///
    /// # Errors
    /// A run differs between shards; two runs of the plan are the same; lists contradict each other
    /// or cannot be read.
    pub fn check(&self) -> Result<Missing, MergeError> {
        let (mut check, mut references) = (ShardCheck::new(self.folders.len()), References::default());
        let mut twins = Twins::default();
        self.for_each_run(&mut |holders: &[Holder]| {
            let run = &holders[0].run;
            twins.add(run);
            if let Some(other) = holders.iter().find(|h| h.run != *run) {
                return Err(self.contradiction(holders[0].shard, other.shard));
            }
            if let Some((holder, record)) = check.check(holders) {
                references.add(self, holder, &record);
            }
            Ok(())
        })?;
        let listed = twins.runs();
        if let Some(twins) = twins.find(self)? {
            return Err(MergeError::Runs(vec![twins]));
        }
        let gaps = self.runs().saturating_sub(listed).saturating_sub(self.unused());
        let mut lines = self.missing_shards();
        if gaps > 0 && lines.is_empty() {
            return Err(MergeError::Runs(vec![format!(
                "{gaps} runs of the plan are in no shard: a {SHARD_LIST} lacks lines"
            )]));
        }
        lines.extend(self.busy.iter().cloned());
        lines.extend(self.unfinished_searches());
        let missing_logs = missing_logs(self, &check)?;
        let ShardCheck { absent, broken, without_result, .. } = check.require_equal()?;
        for (shard, missing) in absent.into_iter().enumerate() {
            lines.extend(missing.line(&self.name(shard)));
        }
        let references = references.require_equal()?;
        lines.extend(references.missing(self));
        lines.extend(missing_logs);
        Ok(Missing { lines, broken, without_result, references })
    }

    fn missing_shards(&self) -> Vec<String> {
        let Some(of) = self.heads.first().map(|head| head.of) else { return Vec::new() };
        let present: BTreeSet<u64> =
            self.heads.iter().map(|head| head.shard).filter(|n| (1..=of).contains(n)).collect();
        let missing = of - present.len() as u64;
        if missing == 0 {
            return Vec::new();
        }
        // A damaged list can state any number of shards: only the first are enumerated.
        let first = (1..=of).filter(|number| !present.contains(number)).take(MAX_NAMED);
        let first: Vec<String> = first.map(|number| number.to_string()).collect();
        let dots = if missing > MAX_NAMED as u64 { ", ..." } else { "" };
        vec![format!("{missing} of {of} shards are missing: {}{dots}", first.join(", "))]
    }
}
