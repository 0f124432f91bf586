//! Differences between two records of one run.

use crate::input::{self, UNLIMITED};
use crate::merge::plan_walk::Holder;
use crate::results::RunRecord;
use serde_json::Value;

/// The first difference between two results of one run, as text. Times and machines may differ, and
/// one may lack the log.
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

/// A record without timing and without the digest of its log; logs are compared themselves.
pub(super) fn comparable(record: &RunRecord) -> Value {
    let mut value = serde_json::to_value(record).unwrap_or(Value::Null);
    if let Value::Object(map) = &mut value {
        map.remove("timing");
        map.remove("log");
    }
    value
}

/// The first difference below `path`, such as `metrics.steps is 3 and 4`.
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
