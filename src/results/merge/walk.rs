//! The lists of several shards side by side, in the order of the plan.

use crate::files::RecordError;
use crate::files::input::{self, UNLIMITED};
use crate::results::merge::{MergeError, Shards};
use crate::results::{RunRecord, ShardList, ShardRun, log_fault};
use serde_json::Value;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::{Path, PathBuf};

/// A shard that has a run.
pub(super) struct Holder<'a> {
    pub shard: usize,
    pub folder: &'a Path,
    pub run: ShardRun,
}

/// What there is of a run.
pub(super) enum Found {
    /// Its record and what this tells of.
    Whole(Box<RunRecord>),
    /// No record.
    Absent,
    /// Something, but no result to take; why.
    Broken(&'static str),
}

impl Holder<'_> {
    /// What it has of the run.
    pub fn find(&self) -> Found {
        if !self.record().exists() {
            return Found::Absent;
        }
        let Ok(record) = RunRecord::read(&self.record()) else { return Found::Broken("its record is no whole record") };
        if (&record.scenario, &record.key) != (&self.run.scenario, &self.run.key) {
            return Found::Broken("its record is that of another run");
        }
        match log_fault(&record, &self.log()) {
            Some(fault) => Found::Broken(fault),
            None => Found::Whole(Box::new(record)),
        }
    }

    pub fn log(&self) -> PathBuf {
        self.record().with_file_name("log.mcap")
    }

    pub fn record(&self) -> PathBuf {
        self.run.folder(self.folder).join("run.json")
    }
}

impl Shards {
    /// Tells of every run that some shard has, with all that have it.
    pub(super) fn walk(&self, tell: &mut dyn FnMut(&[Holder]) -> Result<(), MergeError>) -> Result<(), MergeError> {
        let mut lists = self.folders.iter().map(|f| ShardList::open(f)).collect::<Result<Vec<_>, RecordError>>()?;
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
                        let what = format!("{}: the list is not in order", self.folders[shard].display());
                        return Err(MergeError::Runs(vec![what]));
                    }
                    next.push(Reverse((run.at, shard)));
                }
            }
            tell(&holders)?;
        }
        Ok(())
    }
}

/// What tells two results of one run apart, in words; times and machines may differ, and the log may be missing in one.
pub(super) fn difference(a: &Holder, of_a: &RunRecord, b: &Holder, of_b: &RunRecord) -> Option<String> {
    let (x, y) = (comparable(of_a), comparable(of_b));
    let name = |what: &str| {
        let (run, a, b) = (&a.run, a.folder.display(), b.folder.display());
        Some(format!("{} {}: {what} in {a} and {b}", run.scenario, run.key))
    };
    if let Some(what) = first_difference("", &x, &y) {
        return name(&what);
    }
    let logs = [a, b].map(|holder| input::read(&holder.log(), UNLIMITED).ok());
    match logs {
        [Some(x), Some(y)] if x != y => name("the log differs"),
        _ => None,
    }
}

/// A record without what depends on the clock, and on whether a log was wanted; logs are compared themselves.
pub(super) fn comparable(record: &RunRecord) -> Value {
    let mut value = serde_json::to_value(record).unwrap_or(Value::Null);
    if let Value::Object(map) = &mut value {
        map.remove("timing");
        map.remove("log");
    }
    value
}

/// `metrics.steps is 3 and 4`
pub(super) fn first_difference(path: &str, a: &Value, b: &Value) -> Option<String> {
    let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match (a, b) {
        _ if a == b => None,
        (Value::Object(a), Value::Object(b)) => {
            let names = a.keys().chain(b.keys().filter(|name| !a.contains_key(*name)));
            let value =
                |map: &serde_json::Map<String, Value>, name: &str| map.get(name).cloned().unwrap_or(Value::Null);
            names.into_iter().find_map(|name| first_difference(&below(name), &value(a, name), &value(b, name)))
        }
        _ if path == "resolved" => Some("the scenario differs".into()),
        _ => Some(format!("{path} is {a} and {b}")),
    }
}
