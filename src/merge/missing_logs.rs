//! Detects shards run with `--no-log` among others: one batch writes all logs of its scenarios, or
//! none.

use crate::merge::merge_error::{MAX_NAMED, MergeError};
use crate::merge::plan_walk::{Holder, ShardResult};
use crate::merge::shard_check::ShardCheck;
use crate::merge::shards::Shards;
use crate::results::RunRecord;

/// A line that names runs without the log of their scenario, while others have theirs.
pub(super) fn missing_logs(shards: &Shards, check: &ShardCheck) -> Result<Option<String>, MergeError> {
    // Scenarios are read again only if some runs have a log and others have none.
    if check.with_log == 0 || check.without_log == 0 {
        return Ok(None);
    }
    let mut without = vec![(0, String::new()); shards.folders.len()];
    shards.for_each_run(&mut |holders: &[Holder]| {
        let found = holders.iter().find_map(|holder| match holder.result() {
            ShardResult::Whole(record) if !check.broken.contains(&(holder.shard, holder.run.at)) => {
                Some((holder, record))
            }
            _ => None,
        });
        if let Some((holder, _)) = found.filter(|(holder, record)| !holder.log().exists() && wants_log(record)) {
            let (count, example) = &mut without[holder.shard];
            *count += 1;
            if example.is_empty() {
                *example = format!("{} {}", holder.run.scenario, holder.run.key);
            }
        }
        Ok(())
    })?;
    let affected = without.iter().enumerate().filter(|(_, (count, _))| *count > 0);
    let mut examples: Vec<String> = affected
        .map(|(shard, (count, example))| format!("{count} of {}, such as {example}", shards.name(shard)))
        .collect();
    if examples.is_empty() {
        return Ok(None);
    }
    let dots = if examples.len() > MAX_NAMED { "; ..." } else { "" };
    examples.truncate(MAX_NAMED);
    Ok(Some(format!(
        "some runs have no log (--no-log) and others have one, unlike in a single batch. Without log: {}{dots}; re-run these \
         shards with --resume and without --no-log",
        examples.join("; ")
    )))
}

/// The scenario sets a log rate.
fn wants_log(record: &RunRecord) -> bool {
    let rate = record.resolved.parse::<toml::Table>().ok().and_then(|table| table.get("log")?.get("rate").cloned());
    rate.and_then(|rate| rate.as_float().or(rate.as_integer().map(|i| i as f64))).is_some_and(|rate| rate > 0.0)
}
