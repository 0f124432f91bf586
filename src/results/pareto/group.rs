//! Runs that can be held against each other, and the curves among them.

use crate::results::pareto::Work;
use crate::results::record::compare_values;
use crate::results::{ParamValue, is_truth};
use std::collections::HashMap;
use std::hash::Hash;

/// Keys that say how a run computes, by their first word; runs that differ in others are different problems.
const MANNER: [&str; 4] = ["contact", "integrator", "compare", "log"];

/// Keys below those that say what is computed all the same.
const PROBLEM: [&str; 2] = ["contact.restitution", "contact.forced"];

/// Runs of one problem: the same scenario, and the same value of each swept key that is not about how to compute.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name of the scenario.
    pub scenario: String,
    /// The swept values that its runs share, such as `floor.friction=0.4`; may be empty.
    pub problem: String,
    /// Its curves, in the order of the rows.
    pub curves: Vec<Curve>,
}

/// Runs of one method and integrator that differ in one parameter alone, or in several that change together.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Contact method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// What else distinguishes it from the other curves of its method, such as `integrator.step=0.001`; may be empty.
    pub variant: String,
    /// The parameter along the curve; none when there is a single run, or nothing that varies.
    pub along: Option<String>,
    /// Positions of its rows, in the order of that parameter.
    pub rows: Vec<usize>,
}

impl Curve {
    /// Method, integrator and variant in words.
    pub fn name(&self) -> String {
        let words = [&self.method, &self.integrator, &self.variant];
        words.into_iter().filter(|w| !w.is_empty()).cloned().collect::<Vec<_>>().join(" ")
    }
}

impl Group {
    /// Scenario and problem in words.
    pub fn name(&self) -> String {
        [&self.scenario, &self.problem].into_iter().filter(|w| !w.is_empty()).cloned().collect::<Vec<_>>().join("  ")
    }

    /// Positions of all its rows.
    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.curves.iter().flat_map(|c| c.rows.iter().copied())
    }
}

/// Sorts runs into groups, and those into curves, both in the order in which they are first met.
pub fn groups(works: &[Work]) -> Vec<Group> {
    let problem = |w: &Work| {
        let keys = w.row.parameters.iter().filter(|(name, _)| !is_manner(name) && !is_truth(name));
        (w.row.scenario.clone(), words(keys))
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

fn is_manner(name: &str) -> bool {
    let first = name.split('.').next().unwrap_or_default();
    MANNER.contains(&first) && !PROBLEM.iter().any(|key| name.starts_with(key))
}

/// The curves of one method and integrator.
fn curves(works: &[Work], method: &str, integrator: &str, rows: &[usize]) -> Vec<Curve> {
    let varying = varying(works, rows);
    let along = along(works, rows, &varying);
    // Keys that change together with the one along the curve are told by it.
    let tied = |key: &str| {
        along.as_deref().is_some_and(|along| {
            let by_value = split(rows.iter().copied(), |&i| word(works, i, along));
            by_value.iter().all(|(_, same)| same.iter().all(|&i| word(works, i, key) == word(works, same[0], key)))
        })
    };
    let others: Vec<&String> = varying.iter().filter(|key| !tied(key)).collect();
    let variant = |&i: &usize| {
        let named = others.iter().map(|key| (key.as_str(), word(works, i, key))).filter(|(_, value)| !value.is_empty());
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

/// Swept keys about how to compute whose values differ between the rows, but for method and integrator themselves.
fn varying(works: &[Work], rows: &[usize]) -> Vec<String> {
    let mut keys: Vec<&String> = Vec::new();
    for (name, _) in rows.iter().flat_map(|&i| &works[i].row.parameters) {
        let own_column = ["contact.method", "integrator.method"].contains(&name.as_str());
        if is_manner(name) && !own_column && !is_truth(name) && !keys.contains(&name) {
            keys.push(name);
        }
    }
    let differs = |key: &&String| rows.iter().any(|&i| parameter(works, i, key) != parameter(works, rows[0], key));
    keys.into_iter().filter(differs).cloned().collect()
}

/// The key that a curve runs along: of those that are numbers the one with the most values, the integrator's first.
fn along(works: &[Work], rows: &[usize], varying: &[String]) -> Option<String> {
    let numeric =
        |key: &&String| rows.iter().all(|&i| parameter(works, i, key).is_none_or(|value| value.number().is_some()));
    let values = |key: &str| split(rows.iter().copied(), |&i| word(works, i, key)).len();
    // Of equals the last is taken.
    let mut candidates: Vec<&String> = varying.iter().filter(numeric).collect();
    candidates.reverse();
    candidates.into_iter().max_by_key(|key| (values(key), key.starts_with("integrator."))).cloned()
}

fn parameter<'a>(works: &[Work<'a>], row: usize, key: &str) -> Option<&'a ParamValue> {
    works[row].row.parameters.iter().find(|(name, _)| name == key).map(|(_, value)| value)
}

fn word(works: &[Work], row: usize, key: &str) -> String {
    parameter(works, row, key).map_or_else(String::new, ToString::to_string)
}

/// `name=value`, blank between.
pub(super) fn words<'a>(parameters: impl Iterator<Item = &'a (String, ParamValue)>) -> String {
    parameters.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

/// Items by their key, both in the order in which they are first met.
fn split<T, K: Hash + Eq + Clone>(items: impl Iterator<Item = T>, key: impl Fn(&T) -> K) -> Vec<(K, Vec<T>)> {
    let mut parts: Vec<(K, Vec<T>)> = Vec::new();
    let mut places: HashMap<K, usize> = HashMap::new();
    for item in items {
        let own = key(&item);
        let place = *places.entry(own.clone()).or_insert(parts.len());
        if place == parts.len() {
            parts.push((own, Vec::new()));
        }
        parts[place].1.push(item);
    }
    parts
}
