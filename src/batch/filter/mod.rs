//! Which runs of a plan are meant: an expression over name, key and parameters, such as
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
//! `~` matches a pattern with `*` and `?`, `^=` a beginning. The values of a list are of one kind. A path leads into the run's resolved scenario, where
//! defaults are written out, numbers have SI units and angles are in radians; where that holds a table or a list, the value
//! that a sweep gave under this name counts. A run that has no value there, or one of another kind, satisfies no
//! comparison with it.

mod expression;
mod parse;
mod plan_filter;
mod select;
mod value;

pub use select::Selection;

use std::fmt;

use crate::scenario::Diagnostic;
use expression::Expression;

/// What diagnostics call the text of a filter.
const FILE: &str = "--filter";

/// A parsed expression.
#[derive(Clone, Debug)]
pub struct Filter {
    text: String,
    expression: Expression,
}

impl Filter {
    /// Reads an expression.
    ///
    /// # Errors
    /// What is wrong with it, shown at its place in the text.
    pub fn parse(text: &str) -> Result<Self, Box<Diagnostic>> {
        Ok(Filter { text: text.to_owned(), expression: parse::parse(text)? })
    }
}

/// The expression with every bracket written out; it reads back to the same.
impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expression.fmt(f)
    }
}

fn error(text: &str, at: std::ops::Range<usize>, message: impl Into<String>, help: Option<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::in_text(FILE, text, at, message, help))
}
