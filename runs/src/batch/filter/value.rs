//! Looks up a run's value at a path and compares it.

use super::expression::{Comparison, Relation, Subject};
use crate::results::ParamValue;
use crate::scenario::{Diagnostic, Run, parse, segment};
use crate::text::pattern::matches;

/// Result of one comparison with one run.
pub(super) enum ComparisonResult {
    /// The run has no value there.
    Absent,
    /// The value is not a number, text or flag; help on what to name instead.
    Composite(String),
    /// The value's kind cannot be compared with the expected one.
    OtherKind(ParamValue),
    Held(bool),
}

/// View of a run for comparisons.
pub(super) struct RunView<'a> {
    run: &'a Run,
    key: &'a str,
    /// The resolved scenario, built on first use.
    table: Option<toml::Value>,
}

impl<'a> RunView<'a> {
    pub fn new(run: &'a Run, key: &'a str) -> Self {
        RunView { run, key, table: None }
    }

    /// Evaluates a comparison; sets `same` where the run's value equals an expected value.
    pub fn evaluate(&mut self, comparison: &Comparison, same: &mut [bool]) -> ComparisonResult {
        let value = match &comparison.subject {
            Subject::Name => ParamValue::Text(self.run.name.clone()),
            Subject::Key => ParamValue::Text(self.key.to_owned()),
            Subject::Parameter(path) => match self.parameter(path) {
                Ok(value) => value,
                Err(result) => return result,
            },
        };
        same.iter_mut().zip(&comparison.expected).for_each(|(same, expected)| *same |= value == *expected);
        let mut results = comparison.expected.iter().map(|expected| compare(&value, comparison.relation, expected));
        match comparison.relation {
            Relation::In => match results.by_ref().flatten().reduce(|a, b| a || b) {
                Some(held) => ComparisonResult::Held(held),
                None => ComparisonResult::OtherKind(value),
            },
            _ => results.next().flatten().map_or(ComparisonResult::OtherKind(value), ComparisonResult::Held),
        }
    }

    fn parameter(&mut self, path: &[String]) -> Result<ParamValue, ComparisonResult> {
        let resolved = match lookup(self.table(), path) {
            Some(value) => match scalar(value) {
                Some(value) => return Ok(value),
                None => Some(value.clone()),
            },
            None => None,
        };
        let name = path.iter().map(|s| segment(s)).collect::<Vec<_>>().join(".");
        let swept = self.run.parameters.iter().find(|(other, _)| *other == name);
        match (swept.and_then(|(_, value)| scalar(value)), resolved) {
            (Some(value), _) => Ok(value),
            (None, Some(value)) => Err(ComparisonResult::Composite(values_help(&name, &value))),
            (None, None) => Err(ComparisonResult::Absent),
        }
    }

    /// Collects the names of all comparable values.
    pub fn names(&mut self, out: &mut Vec<String>) {
        leaves(self.table(), String::new(), out);
        let swept = self.run.parameters.iter().filter(|(_, value)| scalar(value).is_some());
        out.extend(swept.map(|(name, _)| name.clone()));
    }

    fn table(&mut self) -> &toml::Value {
        let run = self.run;
        // Planning serialized the scenario without an error.
        let resolve = || toml::Value::Table(run.scenario.to_table().unwrap_or_default());
        self.table.get_or_insert_with(resolve)
    }
}

/// The scenario's error for this text at this path, where `run` has a text; none if allowed.
pub(super) fn refusal(run: &Run, path: &[String], text: &str) -> Option<Diagnostic> {
    let path = path.iter().map(|s| segment(s)).collect::<Vec<_>>().join(".");
    let file = parse(&run.file, run.resolved_toml.as_str()).ok()?;
    let refused = file.expand(&[(path, toml::Value::String(text.to_owned()))]).err()?;
    // Other errors, such as a missing file, may not occur for another run.
    let is_choice =
        |wrong: &Diagnostic| wrong.file == "--set" && wrong.message.ends_with(&format!("cannot be {text:?}"));
    refused.0.into_iter().find(is_choice)
}

/// Evaluates the relation; none if the two cannot be compared.
fn compare(value: &ParamValue, relation: Relation, expected: &ParamValue) -> Option<bool> {
    let equal = match (value, expected) {
        (ParamValue::Text(a), ParamValue::Text(b)) => match relation {
            Relation::Like => return Some(matches(b, a)),
            Relation::Unlike => return Some(!matches(b, a)),
            Relation::Begins => return Some(a.starts_with(b.as_str())),
            _ => a == b,
        },
        (ParamValue::Flag(a), ParamValue::Flag(b)) => a == b,
        (ParamValue::Integer(a), ParamValue::Integer(b)) if !relation.needs_numbers() => a == b,
        (a, b) => {
            let (a, b) = (a.number()?, b.number()?);
            match relation {
                Relation::Less => return Some(a < b),
                Relation::AtMost => return Some(a <= b),
                Relation::Greater => return Some(a > b),
                Relation::AtLeast => return Some(a >= b),
                _ => a == b,
            }
        }
    };
    match relation {
        Relation::Equal | Relation::In => Some(equal),
        Relation::Unequal => Some(!equal),
        _ => None,
    }
}

fn lookup<'a>(root: &'a toml::Value, path: &[String]) -> Option<&'a toml::Value> {
    path.iter().try_fold(root, |at, segment| match at {
        toml::Value::Table(table) => table.get(segment),
        toml::Value::Array(items) => items.get(segment.parse::<usize>().ok()?),
        _ => None,
    })
}

fn scalar(value: &toml::Value) -> Option<ParamValue> {
    match value {
        toml::Value::Integer(i) => Some(ParamValue::Integer(*i)),
        toml::Value::Float(x) => Some(ParamValue::Number(*x)),
        toml::Value::Boolean(b) => Some(ParamValue::Flag(*b)),
        toml::Value::String(s) => Some(ParamValue::Text(s.clone())),
        _ => None,
    }
}

/// Help for a table or list: the values in it.
fn values_help(name: &str, value: &toml::Value) -> String {
    let mut names = Vec::new();
    leaves(value, name.to_owned(), &mut names);
    match names.as_slice() {
        [] => "it is empty".into(),
        [one] => format!("name the value in it: `{one}`"),
        [first, .., last] => format!("name a value in it, from `{first}` to `{last}`"),
    }
}

fn leaves(value: &toml::Value, name: String, out: &mut Vec<String>) {
    let under = |part: &str| if name.is_empty() { part.to_owned() } else { format!("{name}.{part}") };
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, v)| leaves(v, under(&segment(key)), out)),
        toml::Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, v)| leaves(v, under(&i.to_string()), out));
        }
        _ => out.push(name),
    }
}
