//! Groups of comparable runs, and the curves in them.

use crate::results::pareto::Work;
use crate::results::record::compare_values;
use crate::results::{ParamValue, is_truth};
use std::collections::HashMap;
use std::hash::Hash;

/// First segments of keys of numerical methods; runs that differ in other keys solve different
/// problems.
const NUMERICAL: [&str; 4] = ["contact", "integrator", "compare", "log"];

/// Keys below [`NUMERICAL`] that belong to the problem.
const PROBLEM: [&str; 2] = ["contact.restitution", "contact.forced"];

/// Runs of one problem: the same scenario, and the same value of each swept key of the problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name of the scenario.
    pub scenario: String,
    /// The swept values that its runs share, such as `floor.friction=0.4`; may be empty.
    pub problem: String,
    /// Its curves, in the order of the rows.
    pub curves: Vec<Curve>,
}

/// Runs of one method and integrator that differ in one parameter alone, or in several that change
/// together.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Contact method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// Label that distinguishes it from the other curves of its method, such as
    /// `integrator.step=0.001`; may be empty.
    pub variant: String,
    /// The parameter along the curve; none when there is a single run, or nothing that varies.
    pub along: Option<String>,
    /// Positions of its rows, in the order of that parameter.
    pub rows: Vec<usize>,
}

impl Curve {
    /// Method, integrator and variant.
    pub fn name(&self) -> String {
        let parts = [&self.method, &self.integrator, &self.variant];
        parts.into_iter().filter(|w| !w.is_empty()).cloned().collect::<Vec<_>>().join(" ")
    }
}

impl Group {
    /// Scenario and problem.
    pub fn name(&self) -> String {
        [&self.scenario, &self.problem].into_iter().filter(|w| !w.is_empty()).cloned().collect::<Vec<_>>().join("  ")
    }

    /// Positions of all its rows.
    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.curves.iter().flat_map(|c| c.rows.iter().copied())
    }
}

/// Sorts runs into groups and curves, both in the order of first appearance.
pub fn groups(works: &[Work]) -> Vec<Group> {
    let problem = |w: &Work| {
        let keys = w.row.parameters.iter().filter(|(name, _)| !is_numerical(name) && !is_truth(name));
        (w.row.scenario.clone(), parameter_text(keys))
    };
    let cells = split(0..works.len(), |&i| problem(&works[i]));
    let group = |((scenario, problem), rows): ((String, String), Vec<usize>)| Group {
        scenario,
        problem,
        curves: split(rows.iter().copied(), |&i| (&works[i].row.method, &works[i].row.integrator))
            .into_iter()
            .flat_map(|((method, integrator), rows)| curves(works, method, integrator, &rows))
            .collect(),
    };
    cells.into_iter().map(group).collect()
}

fn is_numerical(name: &str) -> bool {
    let first = name.split('.').next().unwrap_or_default();
    NUMERICAL.contains(&first) && !PROBLEM.iter().any(|key| name.starts_with(key))
}

/// The curves of one method and integrator.
fn curves(works: &[Work], method: &str, integrator: &str, rows: &[usize]) -> Vec<Curve> {
    let varying = varying(works, rows);
    let along = along(works, rows, &varying);
    // Keys that change together with the one along the curve need no mention.
    let tied = |key: &str| {
        along.as_deref().is_some_and(|along| {
            let by_value = split(rows.iter().copied(), |&i| value_text(works, i, along));
            by_value
                .iter()
                .all(|(_, same)| same.iter().all(|&i| value_text(works, i, key) == value_text(works, same[0], key)))
        })
    };
    let others: Vec<&String> = varying.iter().filter(|key| !tied(key)).collect();
    let variant = |&i: &usize| {
        let named =
            others.iter().map(|key| (key.as_str(), value_text(works, i, key))).filter(|(_, value)| !value.is_empty());
        (named.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" "), works[i].row.seed)
    };
    split(rows.iter().copied(), variant)
        .into_iter()
        .map(|((variant, _), mut rows)| {
            if let Some(along) = &along {
                rows.sort_by(|&a, &b| compare_values(parameter(works, a, along), parameter(works, b, along)));
            }
            let along = along.clone().filter(|_| rows.len() > 1);
            Curve { method: method.to_owned(), integrator: integrator.to_owned(), variant, along, rows }
        })
        .collect()
}

/// Swept keys of numerical methods whose values differ between the rows, except method and
/// integrator.
fn varying(works: &[Work], rows: &[usize]) -> Vec<String> {
    let mut keys: Vec<&String> = Vec::new();
    for (name, _) in rows.iter().flat_map(|&i| &works[i].row.parameters) {
        let own_column = ["contact.method", "integrator.method"].contains(&name.as_str());
        if is_numerical(name) && !own_column && !is_truth(name) && !keys.contains(&name) {
            keys.push(name);
        }
    }
    let differs = |key: &&String| rows.iter().any(|&i| parameter(works, i, key) != parameter(works, rows[0], key));
    keys.into_iter().filter(differs).cloned().collect()
}

/// The key along a curve: the numeric one with the most values; keys of the integrator take
/// precedence.
fn along(works: &[Work], rows: &[usize], varying: &[String]) -> Option<String> {
    let numeric =
        |key: &&String| rows.iter().all(|&i| parameter(works, i, key).is_none_or(|value| value.number().is_some()));
    let values = |key: &str| split(rows.iter().copied(), |&i| value_text(works, i, key)).len();
    // `max_by_key` takes the last of equals.
    let mut candidates: Vec<&String> = varying.iter().filter(numeric).collect();
    candidates.reverse();
    candidates.into_iter().max_by_key(|key| (values(key), key.starts_with("integrator."))).cloned()
}

fn parameter<'a>(works: &[Work<'a>], row: usize, key: &str) -> Option<&'a ParamValue> {
    works[row].row.parameters.iter().find(|(name, _)| name == key).map(|(_, value)| value)
}

fn value_text(works: &[Work], row: usize, key: &str) -> String {
    parameter(works, row, key).map_or_else(String::new, ToString::to_string)
}

/// Such as `name=value name=value`.
pub(super) fn parameter_text<'a>(parameters: impl Iterator<Item = &'a (String, ParamValue)>) -> String {
    parameters.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

/// Items by their key, both in the order of first appearance.
fn split<T, K: Hash + Eq + Clone>(items: impl Iterator<Item = T>, key: impl Fn(&T) -> K) -> Vec<(K, Vec<T>)> {
    let mut parts: Vec<(K, Vec<T>)> = Vec::new();
    let mut positions: HashMap<K, usize> = HashMap::new();
    for item in items {
        let own = key(&item);
        let position = *positions.entry(own.clone()).or_insert(parts.len());
        if position == parts.len() {
            parts.push((own, Vec::new()));
        }
        parts[position].1.push(item);
    }
    parts
}
