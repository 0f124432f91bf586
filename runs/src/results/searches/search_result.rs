//! The result of a search at one combination of swept values.

use crate::results::ParamValue;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a search found, for one combination of swept values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SearchResult {
    /// Name of the scenario.
    pub scenario: String,
    /// What is searched: `boundary`, `minimum` or `maximum`.
    #[schemars(schema_with = "kinds")]
    pub search: SearchKind,
    /// The condition, such as `outcome fallen`, or the metric.
    pub subject: String,
    /// The searched keys. Values are in this order.
    pub keys: Vec<String>,
    /// True for each key whose values are in equal ratios.
    pub logarithmic: Vec<bool>,
    /// Number of the combination in the plan, from 0.
    pub cell: usize,
    /// The swept values that distinguish it, such as `contact.method=exact`; may be empty.
    pub label: String,
    /// Its swept values under their dotted names.
    pub parameters: BTreeMap<String, ParamValue>,
    /// The result: `found`, `not-monotone`, `no-boundary`, `no-value`, `unconverged`, `unfinished` or
    /// `error`.
    #[schemars(schema_with = "verdicts")]
    pub verdict: SearchVerdict,
    /// Why the search ended without a result; may be empty.
    pub message: String,
    /// The boundary over one key.
    pub interval: Option<Interval>,
    /// The boundary over two keys: lines of points. Those of a closed line end with the first point.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Vec<LinePoint>>,
    /// The run with the least or greatest value.
    pub best: Option<Best>,
    /// Number of its runs.
    pub runs: usize,
    /// Its runs, in the order in which they were chosen. Empty in messages.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<Probe>,
}

/// Kind of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchKind {
    /// Where a condition begins or ceases to hold.
    Boundary,
    /// Where a metric is least.
    Minimum,
    /// Where a metric is greatest.
    Maximum,
}

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchVerdict {
    /// The condition changes within the tolerance, over one key once only; or no value a step away
    /// from the best one is better.
    Found,
    /// Over one key the condition changes more than once.
    NotMonotone,
    /// All values that were run give the same result, those at the ends included.
    NoBoundary,
    /// No run has a value that meets the requirement.
    NoValue,
    /// The allowed number of runs does not suffice.
    Unconverged,
    /// The batch ended before the search did.
    Unfinished,
    /// A run ended in a way that says nothing about the condition.
    Error,
}

/// Two values of a key between which a condition changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// The boundary is at or above this value; of several changes, this one is resolved.
    pub lower: f64,
    /// The boundary is at or below this value.
    pub upper: f64,
    /// True if the condition holds at `upper` and not at `lower`, false for the opposite.
    pub holds_above: bool,
    /// Pairs of neighbouring values that were run and gave different results, in ascending order.
    pub changes: Vec<[f64; 2]>,
}

/// Two neighbouring pairs of values between which a condition changes. They differ in one key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LinePoint {
    /// The lower ones.
    pub lower: [f64; 2],
    /// The upper ones.
    pub upper: [f64; 2],
    /// True if the condition holds at `upper` and not at `lower`, false for the opposite.
    pub holds_above: bool,
}

/// The best run of a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Best {
    /// Its values of the keys.
    pub at: Vec<f64>,
    /// Its value of the metric, in the metric's unit.
    pub value: f64,
    /// Key of the run.
    pub run: String,
}

/// One run of a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Probe {
    /// Its values of the keys.
    pub at: Vec<f64>,
    /// Key of the run.
    pub run: String,
    /// Outcome of the run.
    pub outcome: String,
    /// True if the condition holds; none if the run says nothing about it, or has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// The metric; none if it is not measured, or the run must not be chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
}

fn kinds(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "type": "string", "enum": SearchKind::ALL.map(SearchKind::name) })
}

fn verdicts(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "type": "string", "enum": SearchVerdict::ALL.map(SearchVerdict::name) })
}

impl SearchKind {
    /// All kinds.
    pub const ALL: [SearchKind; 3] = [SearchKind::Boundary, SearchKind::Minimum, SearchKind::Maximum];

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            SearchKind::Boundary => "boundary",
            SearchKind::Minimum => "minimum",
            SearchKind::Maximum => "maximum",
        }
    }
}

impl SearchVerdict {
    /// All verdicts.
    pub const ALL: [SearchVerdict; 7] = [
        SearchVerdict::Found,
        SearchVerdict::NotMonotone,
        SearchVerdict::NoBoundary,
        SearchVerdict::NoValue,
        SearchVerdict::Unconverged,
        SearchVerdict::Unfinished,
        SearchVerdict::Error,
    ];

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            SearchVerdict::Found => "found",
            SearchVerdict::NotMonotone => "not-monotone",
            SearchVerdict::NoBoundary => "no-boundary",
            SearchVerdict::NoValue => "no-value",
            SearchVerdict::Unconverged => "unconverged",
            SearchVerdict::Unfinished => "unfinished",
            SearchVerdict::Error => "error",
        }
    }
}

impl LinePoint {
    /// The middle of both.
    pub fn middle(&self) -> [f64; 2] {
        [0, 1].map(|i| 0.5 * (self.lower[i] + self.upper[i]))
    }
}

/// A number with all digits, as a power of ten where it is small or large.
fn shown(x: f64) -> String {
    if x == 0.0 || (1e-4..1e12).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

impl SearchResult {
    /// True if all values belong to its keys, of which a boundary has one or two.
    pub fn is_consistent(&self) -> bool {
        let keys = self.keys.len();
        let known = if self.search == SearchKind::Boundary { (1..=2).contains(&keys) } else { keys > 0 };
        let best = self.best.as_ref().is_none_or(|best| best.at.len() == keys);
        known && best && self.logarithmic.len() == keys && self.probes.iter().all(|probe| probe.at.len() == keys)
    }

    /// Such as `outcome fallen`, `least peak_torque`.
    pub fn goal(&self) -> String {
        match self.search {
            SearchKind::Boundary => self.subject.clone(),
            SearchKind::Minimum => format!("least {}", self.subject),
            SearchKind::Maximum => format!("greatest {}", self.subject),
        }
    }

    /// Such as `33.4 to 33.5`, `2 lines of 60 points`, `0.31 at a = 4, b = 0.5`; empty without any.
    pub fn found(&self) -> String {
        let points: usize = self.lines.iter().map(Vec::len).sum();
        match (&self.interval, &self.best, self.lines.len()) {
            (Some(Interval { lower, upper, .. }), ..) => format!("{} to {}", shown(*lower), shown(*upper)),
            (None, Some(best), _) => {
                let at: Vec<String> =
                    self.keys.iter().zip(&best.at).map(|(key, x)| format!("{key} = {}", shown(*x))).collect();
                format!("{} at {}", shown(best.value), at.join(", "))
            }
            (None, None, 0) => String::new(),
            (None, None, 1) => format!("a line of {points} points"),
            (None, None, n) => format!("{n} lines of {points} points"),
        }
    }

    /// One line: what was found, or why nothing was.
    pub fn summary(&self) -> String {
        let (subject, keys) = (&self.subject, self.keys.join(", "));
        match self.verdict {
            SearchVerdict::Found => match &self.interval {
                Some(interval) => {
                    let side = if interval.holds_above { "above" } else { "below" };
                    format!("{subject} holds {side} {keys} = {}", self.found())
                }
                None => format!("{}: {}", self.goal(), self.found()),
            },
            SearchVerdict::NotMonotone => {
                let changes = self.interval.iter().flat_map(|interval| &interval.changes);
                let all: Vec<String> =
                    changes.map(|[low, high]| format!("{} to {}", shown(*low), shown(*high))).collect();
                format!("{subject} changes more than once over {keys}: {}", all.join(", "))
            }
            SearchVerdict::NoBoundary => match self.probes.first().and_then(|probe| probe.holds) {
                Some(true) => format!("{subject} holds for all values of {keys} that were run"),
                Some(false) => format!("{subject} holds for no value of {keys} that was run"),
                None => format!("{subject} is the same for all values of {keys} that were run"),
            },
            SearchVerdict::NoValue => format!("no run has a value of {subject} that may be chosen"),
            SearchVerdict::Unconverged => {
                let found = self.found();
                let so_far = if found.is_empty() { found } else { format!("; so far {found}") };
                format!("{} runs do not suffice{so_far}", self.runs)
            }
            SearchVerdict::Unfinished | SearchVerdict::Error => self.message.clone(),
        }
    }
}
