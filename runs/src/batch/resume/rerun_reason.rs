//! Reports why a run differs from its earlier record: which inputs of its key changed.

use std::collections::BTreeMap;
use std::path::Path;

use crate::batch::Job;
use crate::batch::plan::input_hashes::input_hashes;
use crate::results::{InputHash, PROGRAM, RunRecord};

/// Changes listed by name; the rest are counted.
const MAX_NAMED: usize = 4;

/// Values that do not enter the key.
const NOT_IN_KEY: [&str; 2] = ["robot.model", "compare.timing_repeats"];

/// Describes what changed since a record was written; none if nothing did.
pub(in crate::batch) fn why(job: &Job, record: &RunRecord) -> Option<String> {
    let mut changes = Vec::new();
    if record.program != PROGRAM {
        changes.push(format!("the program was {}, is {PROGRAM}", record.program));
    }
    changes.extend(values(&record.resolved, &job.run.resolved_toml));
    changes.extend(files(job, &record.inputs));
    let more = changes.len().saturating_sub(MAX_NAMED);
    changes.truncate(MAX_NAMED);
    if more > 0 {
        changes.push(format!("{more} more changes"));
    }
    (!changes.is_empty()).then(|| changes.join("; "))
}

/// Changed values of the scenario.
fn values(before: &str, now: &str) -> Vec<String> {
    let leaves = |text: &str| {
        let mut leaves = BTreeMap::new();
        if let Ok(table) = text.parse::<toml::Table>() {
            gather("", &toml::Value::Table(table), &mut leaves);
        }
        leaves
    };
    let (before, now) = (leaves(before), leaves(now));
    let changed = now.iter().filter_map(|(path, is)| match before.get(path) {
        Some(was) if was == is => None,
        Some(was) => Some(format!("`{path}` was {was}, is {is}")),
        None => Some(format!("`{path}` = {is} is new")),
    });
    let removed = before.iter().filter(|(path, _)| !now.contains_key(*path));
    changed.chain(removed.map(|(path, was)| format!("`{path}` = {was} was removed"))).collect()
}

/// Collects every value except tables under its dotted path.
fn gather(path: &str, value: &toml::Value, leaves: &mut BTreeMap<String, String>) {
    let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(name, value)| gather(&below(&crate::scenario::segment(name)), value, leaves));
        }
        toml::Value::Array(items) if items.iter().any(toml::Value::is_table) => {
            items.iter().enumerate().for_each(|(i, value)| gather(&below(&i.to_string()), value, leaves));
        }
        _ if NOT_IN_KEY.contains(&path) || is_object_model(path) => {}
        _ => {
            leaves.insert(path.to_owned(), value.to_string());
        }
    }
}

/// True for the path of an object's model, whose bytes enter the key.
fn is_object_model(path: &str) -> bool {
    let entry = path.strip_prefix("object.").and_then(|rest| rest.strip_suffix(".model"));
    entry.is_some_and(|entry| !entry.contains('.'))
}

/// Kind of a robot's file, for messages.
fn kind(path: &Path) -> String {
    let is_text = path.extension().is_some_and(|e| ["toml", "urdf", "xml"].iter().any(|x| e.eq_ignore_ascii_case(x)));
    if is_text { "robot file" } else { "mesh" }.to_owned()
}

/// Changed files of the robot and files that the scenario names.
fn files(job: &Job, before: &[InputHash]) -> Vec<String> {
    let now = input_hashes(job);
    let robots = std::iter::once(&job.robot).chain(&job.objects);
    let kinds = robots
        .flat_map(|robot| robot.files.iter().map(|(path, _)| kind(path)))
        .chain(job.run.inputs.iter().map(|input| format!("`{}`, the file", input.key)));
    let changed = now.iter().zip(kinds).filter_map(|(is, kind)| match before.iter().find(|was| was.name == is.name) {
        Some(was) if was.blake3 == is.blake3 => None,
        Some(_) => Some(format!("{kind} {} changed", is.name)),
        None => Some(format!("{kind} {} is new", is.name)),
    });
    let removed = before.iter().filter(|was| !now.iter().any(|is| is.name == was.name));
    changed.chain(removed.map(|was| format!("the file {} was removed", was.name))).collect()
}
