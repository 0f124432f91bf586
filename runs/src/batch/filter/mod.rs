//! Selects runs by an expression over name, key and parameters, such as
//!
//! ```text
//! name ~ "push*" and (contact.method == "exact" or not floor.friction.static >= 0.5)
//! ```
//!
//! ```text
//! any        = all { "or" all }
//! all        = one { "and" one }
//! one        = "not" one | "(" any ")" | subject relation
//! subject    = "name" | "key" | dotted path of a parameter
//! relation   = ( "==" | "!=" ) value | ( "<" | "<=" | ">" | ">=" ) number
//!            | ( "~" | "!~" | "^=" ) text | "in" "[" value { "," value } [ "," ] "]"
//! value      = number | text in double or single quotes | "true" | "false"
//! ```
//!
//! `~` matches a pattern with `*` and `?`, `^=` a prefix. The values of a list have one kind. A
//! path refers to the run's resolved scenario, with defaults written out, numbers in SI units and
//! angles in radians. If that value is a table or list, the swept value of this name is used. A run
//! without a value there, or with one of another kind, satisfies no comparison with it.

mod expression;
mod literal;
mod parse;
mod plan_filter;
mod select;
mod value;

pub use select::Selection;

use std::fmt;

use crate::scenario::Diagnostic;
use expression::Expression;

/// Name of a filter's text in diagnostics.
const FILE: &str = "--filter";

/// A parsed expression.
#[derive(Clone, Debug)]
pub struct Filter {
    text: String,
    expression: Expression,
}

impl Filter {
    /// Parses an expression.
    ///
    /// # Errors
    /// A syntax error, with its position in the text.
    pub fn parse(text: &str) -> Result<Self, Box<Diagnostic>> {
        Ok(Filter { text: text.to_owned(), expression: parse::parse(text)? })
    }

    /// An error if a comparison is about one of these keys, whose values a search chooses, or about the
    /// keys of its runs.
    pub(in crate::batch) fn names_any<'a>(&self, searched: impl Iterator<Item = &'a str>) -> Option<Box<Diagnostic>> {
        let searched: Vec<&str> = searched.collect();
        let comparisons = self.expression.comparisons();
        let is_searched = |name: &str| searched.contains(&name) || name == "key" && !searched.is_empty();
        let wrong = comparisons.into_iter().find(|comparison| is_searched(&comparison.subject.to_string()))?;
        let message = format!("`{}` cannot select runs: a search chooses them while the batch runs", wrong.subject);
        let help = "select combinations of swept values".to_owned();
        Some(error(&self.text, wrong.at.clone(), message, Some(help)))
    }
}

/// Writes the expression with all brackets; parsing it gives the same expression.
impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expression.fmt(f)
    }
}

fn error(text: &str, at: std::ops::Range<usize>, message: impl Into<String>, help: Option<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::in_text(FILE, text, at, message, help))
}
