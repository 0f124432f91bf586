//! Compares what the searches of two results found.

use serde::Serialize;

use crate::compare::Results;
use crate::results::searches::SearchResult;

/// A search that found something else.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SearchChange {
    /// Scenario, swept values, goal and keys of the search.
    pub search: String,
    /// Verdict in A, with what was found.
    pub a: String,
    /// The same in B.
    pub b: String,
}

/// Searches of both results that found different values or have different verdicts, in the order of A.
/// They are in `searches.json` next to the rows.
pub(super) fn search_changes(a: &Results, b: &Results) -> Vec<SearchChange> {
    let (a, b) = (a.searches(), b.searches());
    let change = |first: &SearchResult| {
        let second = b.iter().find(|other| identity(other) == identity(first))?;
        let is_equal = first.verdict == second.verdict
            && first.interval == second.interval
            && first.lines == second.lines
            && value(first) == value(second);
        let side =
            |search: &SearchResult| format!("{} {}", search.verdict.name(), search.found()).trim_end().to_owned();
        (!is_equal).then(|| SearchChange { search: name(first), a: side(first), b: side(second) })
    };
    a.iter().filter_map(change).collect()
}

/// What two results of the same search have in common.
fn identity(search: &SearchResult) -> (&str, &str, String, &[String]) {
    (&search.scenario, &search.label, search.goal(), &search.keys)
}

/// The best value and where it is. The key of its run may differ.
fn value(search: &SearchResult) -> Option<(&[f64], f64)> {
    search.best.as_ref().map(|best| (best.at.as_slice(), best.value))
}

fn name(search: &SearchResult) -> String {
    let label = if search.label.is_empty() { String::new() } else { format!(" {}", search.label) };
    format!("{}{label}: {} over {}", search.scenario, search.goal(), search.keys.join(", "))
}
