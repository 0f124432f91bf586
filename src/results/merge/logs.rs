//! Shards of which some were made with `--no-log`: one batch leaves all logs that the scenarios ask for, or none.

use crate::results::RunRecord;
use crate::results::merge::look::Look;
use crate::results::merge::walk::{Found, Holder};
use crate::results::merge::{MOST_NAMED, MergeError, Shards};

/// In words, which runs left no log though they were to, when others left theirs.
pub(super) fn unlike(shards: &Shards, looked: &Look) -> Result<Option<String>, MergeError> {
    // Only then is it worth to look at each scenario.
    if looked.with_log == 0 || looked.without_log == 0 {
        return Ok(None);
    }
    let mut without = vec![(0, String::new()); shards.folders.len()];
    shards.walk(&mut |holders: &[Holder]| {
        let found = holders.iter().find_map(|holder| match holder.find() {
            Found::Whole(record) if !looked.broken.contains(&(holder.shard, holder.run.at)) => Some((holder, record)),
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
    let mut words: Vec<String> = Vec::new();
    for (shard, (count, example)) in without.iter().enumerate().filter(|(_, (count, _))| *count > 0) {
        words.push(format!("{count} of {}, such as {example}", shards.name(shard)));
    }
    if words.is_empty() {
        return Ok(None);
    }
    let dots = if words.len() > MOST_NAMED { "; ..." } else { "" };
    words.truncate(MOST_NAMED);
    Ok(Some(format!(
        "some runs left no log (--no-log) and others did: no single batch leaves that. Without are {}{dots}; run them again \
         with --resume and without --no-log",
        words.join("; ")
    )))
}

/// Does its scenario ask for a log?
fn wants_log(record: &RunRecord) -> bool {
    let rate = record.resolved.parse::<toml::Table>().ok().and_then(|table| table.get("log")?.get("rate").cloned());
    rate.and_then(|rate| rate.as_float().or(rate.as_integer().map(|i| i as f64))).is_some_and(|rate| rate > 0.0)
}
