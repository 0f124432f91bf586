//! Two records of one run.

use super::Difference;
use crate::results::RunRecord;
use serde_json::Value;

/// What depends on the moment, the machine, the sweep or the inputs, and not on what happened; logs are compared themselves.
const APART: [&str; 7] = ["timing", "parameters", "inputs", "key", "program", "resolved", "log"];

/// The first value that differs.
pub(super) fn compare(then: &RunRecord, now: &RunRecord) -> Option<Difference> {
    // Both are plain data; a number that JSON does not have is a word in it.
    let (then, now) = (serde_json::to_value(then).ok()?, serde_json::to_value(now).ok()?);
    let mut found = Vec::new();
    walk("", &then, &now, &mut found);
    let more = found.len().saturating_sub(1);
    let (place, then, now) = found.into_iter().next()?;
    Some(Difference { file: "run.json", place, values: Some((then, now)), more })
}

/// Compares value by value; numbers by their shortest digits, which two different numbers never share.
fn walk(place: &str, then: &Value, now: &Value, found: &mut Vec<(String, String, String)>) {
    let below = |key: &str| if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") };
    match (then, now) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            for key in keys.filter(|key| !place.is_empty() || !APART.contains(&key.as_str())) {
                let of = |map: &serde_json::Map<String, Value>| map.get(key).cloned().unwrap_or(Value::Null);
                walk(&below(key), &of(a), &of(b), found);
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            for i in 0..a.len().max(b.len()) {
                let of = |list: &[Value]| list.get(i).cloned().unwrap_or(Value::Null);
                walk(&below(&i.to_string()), &of(a), &of(b), found);
            }
        }
        (a, b) => {
            // As words, since 0 and -0 are equal as numbers.
            let (a, b) = (a.to_string(), b.to_string());
            if a != b {
                found.push((place.to_owned(), a, b));
            }
        }
    }
}
