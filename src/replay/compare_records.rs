//! Compares the records of a run and its re-run.

use crate::files::names;
use crate::replay::difference::Difference;
use crate::results::RunRecord;
use serde_json::Value;

/// Keys that are not compared: they depend on time, machine, sweep or inputs. Logs are compared
/// themselves.
const NOT_COMPARED: [&str; 7] = ["timing", "parameters", "inputs", "key", "program", "resolved", "log"];

/// The first value that differs.
pub(super) fn compare(then: &RunRecord, now: &RunRecord) -> Option<Difference> {
    // Both are plain data; numbers that JSON lacks are texts in it.
    let (then, now) = (serde_json::to_value(then).ok()?, serde_json::to_value(now).ok()?);
    let mut found = Vec::new();
    walk("", &then, &now, &mut found);
    let more = found.len().saturating_sub(1);
    let (position, then, now) = found.into_iter().next()?;
    Some(Difference { file: names::RUN_RECORD, position, values: Some((then, now)), more })
}

/// Compares value by value; numbers by their shortest digits, which differ for different numbers.
fn walk(path: &str, then: &Value, now: &Value, found: &mut Vec<(String, String, String)>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (then, now) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            for key in keys.filter(|key| !path.is_empty() || !NOT_COMPARED.contains(&key.as_str())) {
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
            // As texts, since 0 and -0 are equal as numbers.
            let (a, b) = (a.to_string(), b.to_string());
            if a != b {
                found.push((path.to_owned(), a, b));
            }
        }
    }
}
