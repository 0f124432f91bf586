//! Selects runs one by one; at the end, reports comparisons that applied to no run.

use std::rc::Rc;

use super::Filter;
use super::expression::{Comparison, Subject};
use super::literal::kind;
use super::value::{ComparisonResult, RunView, refusal};
use crate::results::ParamValue;
use crate::scenario::{Diagnostic, Run};
use crate::text::suggest;

/// Selects runs and records the values that each comparison met.
pub struct Selection<'a> {
    filter: &'a Filter,
    comparisons: Vec<(&'a Comparison, Met)>,
    /// Result of each comparison with the current run.
    results: Vec<bool>,
    /// For each comparison: which values some run has, and a run with a value of their kind.
    matched: Vec<(Vec<bool>, Option<Rc<Run>>)>,
    /// Parameter names, collected only while a comparison has met no value.
    names: Vec<String>,
}

/// Best match of a comparison so far.
enum Met {
    Nothing,
    Composite(String),
    OtherKind(ParamValue),
    Comparable,
}

impl Met {
    fn rank(&self) -> u8 {
        match self {
            Met::Nothing => 0,
            Met::Composite(_) => 1,
            Met::OtherKind(_) => 2,
            Met::Comparable => 3,
        }
    }
}

impl<'a> Selection<'a> {
    /// Starts a selection.
    pub fn new(filter: &'a Filter) -> Self {
        let comparisons: Vec<_> = filter.expression.comparisons().into_iter().map(|c| (c, Met::Nothing)).collect();
        let results = vec![false; comparisons.len()];
        let matched =
            comparisons.iter().map(|(comparison, _)| (vec![false; comparison.expected.len()], None)).collect();
        Selection { filter, comparisons, results, matched, names: Vec::new() }
    }

    /// True if the filter selects this run.
    pub fn takes(&mut self, run: &Run, key: &str) -> bool {
        let mut view = RunView::new(run, key);
        let mut unmatched = false;
        // All comparisons share one copy of the run.
        let mut shared: Option<Rc<Run>> = None;
        let all = self.comparisons.iter_mut().zip(&mut self.results).zip(&mut self.matched);
        for (((comparison, met), held), (same, example)) in all {
            let now = match view.evaluate(comparison, same) {
                ComparisonResult::Held(yes) => {
                    *held = yes;
                    if example.is_none() && comparison.names_texts() {
                        *example = Some(shared.get_or_insert_with(|| Rc::new(run.clone())).clone());
                    }
                    *met = Met::Comparable;
                    continue;
                }
                ComparisonResult::Absent => Met::Nothing,
                ComparisonResult::Composite(help) => Met::Composite(help),
                ComparisonResult::OtherKind(value) => Met::OtherKind(value),
            };
            *held = false;
            if now.rank() > met.rank() {
                *met = now;
            }
            unmatched |= matches!(met, Met::Nothing);
        }
        if unmatched {
            view.names(&mut self.names);
            self.names.sort_unstable();
            self.names.dedup();
        }
        self.filter.expression.value(&self.results)
    }

    /// Checks that every comparison applied to some run and every unmatched text is possible.
    ///
    /// # Errors
    /// The first violation, with a suggestion.
    pub fn end(self) -> Result<(), Box<Diagnostic>> {
        for (comparison, met) in &self.comparisons {
            let name = comparison.subject.to_string();
            let wrong = |message: String, help: Option<String>| {
                Err(super::error(&self.filter.text, comparison.at.clone(), message, help))
            };
            match met {
                Met::Comparable => {}
                Met::Nothing => return wrong(format!("no run has a parameter `{name}`"), Some(self.suggestion(&name))),
                Met::Composite(help) => {
                    return wrong(format!("`{name}` is not a number, a text or a flag"), Some(help.clone()));
                }
                Met::OtherKind(value) => {
                    let message = format!("`{name}` is {}, such as {}", kind(value), display(value));
                    let help = format!("it cannot be compared with {}", kind(&comparison.expected[0]));
                    let at = comparison.expected_at.clone();
                    return Err(super::error(&self.filter.text, at, message, Some(help)));
                }
            }
        }
        self.check_texts()
    }

    /// Refuses a text that no run can have, such as "exct" for `contact.method`.
    fn check_texts(&self) -> Result<(), Box<Diagnostic>> {
        for ((comparison, _), (same, example)) in self.comparisons.iter().zip(&self.matched) {
            let (Subject::Parameter(path), Some(run)) = (&comparison.subject, example) else { continue };
            let unmatched = comparison.expected.iter().zip(&comparison.values_at).zip(same).filter(|(_, same)| !**same);
            for ((expected, at), _) in unmatched {
                let ParamValue::Text(text) = expected else { continue };
                if let Some(wrong) = refusal(run, path, text) {
                    return Err(super::error(&self.filter.text, at.clone(), wrong.message, wrong.help));
                }
            }
        }
        Ok(())
    }

    /// Suggests the nearest name, else one with the same last segment, else where to find names.
    fn suggestion(&self, name: &str) -> String {
        let known = ["name", "key"].into_iter().chain(self.names.iter().map(String::as_str));
        let near = suggest(name, known);
        if near.starts_with("did you mean") {
            return near;
        }
        let last = |path: &str| path.rsplit('.').next().unwrap_or(path).to_owned();
        match self.names.iter().find(|other| last(other) == last(name)) {
            Some(other) => format!("did you mean `{other}`?"),
            None => "parameters are paths into the resolved scenario, `resolved` in `run.json`".into(),
        }
    }
}

fn display(value: &ParamValue) -> String {
    match value {
        ParamValue::Text(text) => super::literal::quoted(text),
        other => other.to_string(),
    }
}
