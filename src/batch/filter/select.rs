//! Selects runs one by one; at the end, reports comparisons that applied to no run.

use std::rc::Rc;

use super::Filter;
use super::expression::{Comparison, Subject};
use super::parse::kind;
use super::value::{Answer, Seen, refusal};
use crate::results::ParamValue;
use crate::scenario::{Diagnostic, Run};
use crate::text::suggest;

/// Selects runs and records the values that each comparison met.
pub struct Selection<'a> {
    filter: &'a Filter,
    comparisons: Vec<(&'a Comparison, Met)>,
    held: Vec<bool>,
    /// For each comparison: which values some run has, and a run with a value of their kind.
    same: Vec<(Vec<bool>, Option<Rc<Run>>)>,
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
        let held = vec![false; comparisons.len()];
        let same = comparisons.iter().map(|(comparison, _)| (vec![false; comparison.wanted.len()], None)).collect();
        Selection { filter, comparisons, held, same, names: Vec::new() }
    }

    /// Does the filter select this run?
    pub fn takes(&mut self, run: &Run, key: &str) -> bool {
        let mut seen = Seen::new(run, key);
        let mut lost = false;
        // All comparisons share one copy of the run.
        let mut shared: Option<Rc<Run>> = None;
        let all = self.comparisons.iter_mut().zip(&mut self.held).zip(&mut self.same);
        for (((comparison, met), held), (same, example)) in all {
            let now = match seen.answer(comparison, same) {
                Answer::Held(yes) => {
                    *held = yes;
                    if example.is_none() && comparison.names_words() {
                        *example = Some(shared.get_or_insert_with(|| Rc::new(run.clone())).clone());
                    }
                    *met = Met::Comparable;
                    continue;
                }
                Answer::Absent => Met::Nothing,
                Answer::Composite(words) => Met::Composite(words),
                Answer::OtherKind(value) => Met::OtherKind(value),
            };
            *held = false;
            if now.rank() > met.rank() {
                *met = now;
            }
            lost |= matches!(met, Met::Nothing);
        }
        if lost {
            seen.names(&mut self.names);
            self.names.sort_unstable();
            self.names.dedup();
        }
        self.filter.expression.value(&self.held)
    }

    /// Checks that every comparison applied to some run and every unmatched word is possible.
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
                Met::Nothing => return wrong(format!("no run has a parameter `{name}`"), Some(self.meant(&name))),
                Met::Composite(words) => {
                    return wrong(format!("`{name}` is neither a number nor a text nor a flag"), Some(words.clone()));
                }
                Met::OtherKind(value) => {
                    let message = format!("`{name}` is {}, such as {}", kind(value), shown(value));
                    let help = format!("it cannot be compared with {}", kind(&comparison.wanted[0]));
                    let at = comparison.wanted_at.clone();
                    return Err(super::error(&self.filter.text, at, message, Some(help)));
                }
            }
        }
        self.words()
    }

    /// Refuses a word that no run can have, such as "exct" for `contact.method`.
    fn words(&self) -> Result<(), Box<Diagnostic>> {
        for ((comparison, _), (same, example)) in self.comparisons.iter().zip(&self.same) {
            let (Subject::Parameter(path), Some(run)) = (&comparison.subject, example) else { continue };
            let strange = comparison.wanted.iter().zip(&comparison.values_at).zip(same).filter(|(_, same)| !**same);
            for ((wanted, at), _) in strange {
                let ParamValue::Text(word) = wanted else { continue };
                if let Some(wrong) = refusal(run, path, word) {
                    return Err(super::error(&self.filter.text, at.clone(), wrong.message, wrong.help));
                }
            }
        }
        Ok(())
    }

    /// Suggests the nearest name, else one with the same last segment, else where to find names.
    fn meant(&self, name: &str) -> String {
        let known = ["name", "key"].into_iter().chain(self.names.iter().map(String::as_str));
        let near = suggest(name, known);
        if near.starts_with("did you mean") {
            return near;
        }
        let last = |path: &str| path.rsplit('.').next().unwrap_or(path).to_owned();
        match self.names.iter().find(|other| last(other) == last(name)) {
            Some(other) => format!("did you mean `{other}`?"),
            None => "a path into the scenario with its defaults, which `run.json` has under `resolved`".into(),
        }
    }
}

fn shown(value: &ParamValue) -> String {
    match value {
        ParamValue::Text(text) => super::parse::quoted(text),
        other => other.to_string(),
    }
}
