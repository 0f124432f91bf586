//! Parsed filter expressions.

use std::fmt;
use std::ops::Range;

use crate::results::ParamValue;

/// An expression over one run.
#[derive(Clone, Debug)]
pub(super) enum Expression {
    /// Two or more operands in one list, so that the tree is only as deep as its brackets.
    Any(Vec<Expression>),
    All(Vec<Expression>),
    Not(Box<Expression>),
    /// A comparison and its number in the text, from 0.
    Holds(usize, Comparison),
}

/// Compares a property of a run with written values.
#[derive(Clone, Debug)]
pub(super) struct Comparison {
    pub subject: Subject,
    pub relation: Relation,
    /// At least one, all of one kind; several only with [`Relation::In`]. Patterns have `\` before
    /// literal characters, as in double quotes.
    pub wanted: Vec<ParamValue>,
    /// Range of the subject in the text.
    pub at: Range<usize>,
    /// Range of the right side.
    pub wanted_at: Range<usize>,
    /// Range of each value.
    pub values_at: Vec<Range<usize>>,
}

/// Property of a run that a comparison uses.
#[derive(Clone, Debug)]
pub(super) enum Subject {
    /// Name of the scenario.
    Name,
    /// Key of the run.
    Key,
    /// A path into the scenario, by segments.
    Parameter(Vec<String>),
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Relation {
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
    Like,
    Unlike,
    Begins,
    In,
}

impl Relation {
    /// Longer signs first, so that a prefix does not match instead.
    pub const SIGNS: [(&str, Relation); 9] = [
        ("==", Relation::Equal),
        ("!=", Relation::Unequal),
        ("<=", Relation::AtMost),
        (">=", Relation::AtLeast),
        ("!~", Relation::Unlike),
        ("^=", Relation::Begins),
        ("<", Relation::Less),
        (">", Relation::Greater),
        ("~", Relation::Like),
    ];

    fn sign(self) -> &'static str {
        Self::SIGNS.iter().find(|(_, relation)| *relation == self).map_or("in", |(sign, _)| sign)
    }

    /// Does it need numbers?
    pub fn orders(self) -> bool {
        matches!(self, Relation::Less | Relation::AtMost | Relation::Greater | Relation::AtLeast)
    }

    /// The sign after swapping both sides; none where swapping makes no sense.
    pub fn turned(self) -> Option<&'static str> {
        match self {
            Relation::Equal | Relation::Unequal => Some(self.sign()),
            Relation::Less => Some(">"),
            Relation::AtMost => Some(">="),
            Relation::Greater => Some("<"),
            Relation::AtLeast => Some("<="),
            Relation::Like | Relation::Unlike | Relation::Begins | Relation::In => None,
        }
    }

    /// Does it test equality?
    pub fn equals(self) -> bool {
        matches!(self, Relation::Equal | Relation::Unequal | Relation::In)
    }

    /// Does it take a pattern?
    pub fn globs(self) -> bool {
        matches!(self, Relation::Like | Relation::Unlike)
    }

    /// Does it need texts?
    pub fn reads(self) -> bool {
        matches!(self, Relation::Like | Relation::Unlike | Relation::Begins)
    }
}

impl Comparison {
    /// Does it compare a parameter with words, which may be misspelt?
    pub fn names_words(&self) -> bool {
        let is_word = |value: &ParamValue| matches!(value, ParamValue::Text(_));
        self.relation.equals() && matches!(self.subject, Subject::Parameter(_)) && self.wanted.iter().any(is_word)
    }
}

impl Expression {
    /// All comparisons, in the order of the text.
    pub fn comparisons(&self) -> Vec<&Comparison> {
        match self {
            Expression::Any(all) | Expression::All(all) => all.iter().flat_map(Expression::comparisons).collect(),
            Expression::Not(a) => a.comparisons(),
            Expression::Holds(_, comparison) => vec![comparison],
        }
    }

    /// Evaluates the expression, given the result of each comparison.
    pub fn value(&self, held: &[bool]) -> bool {
        match self {
            Expression::Any(all) => all.iter().any(|one| one.value(held)),
            Expression::All(all) => all.iter().all(|one| one.value(held)),
            Expression::Not(a) => !a.value(held),
            Expression::Holds(index, _) => held[*index],
        }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Expression::Any(all) | Expression::All(all) => {
                let word = if matches!(self, Expression::Any(_)) { " or " } else { " and " };
                let all: Vec<String> = all.iter().map(Expression::to_string).collect();
                write!(f, "({})", all.join(word))
            }
            Expression::Not(a) => write!(f, "not {a}"),
            Expression::Holds(_, Comparison { subject, relation, wanted, .. }) => {
                let literal = |value: &ParamValue| match value {
                    // Patterns are stored as written in double quotes.
                    ParamValue::Text(pattern) if relation.globs() => format!("\"{pattern}\""),
                    ParamValue::Text(text) => super::parse::quoted(text),
                    other => other.to_string(),
                };
                let values: Vec<String> = wanted.iter().map(literal).collect();
                match relation {
                    Relation::In => write!(f, "{subject} in [{}]", values.join(", ")),
                    _ => write!(f, "{subject} {} {}", relation.sign(), values.join(", ")),
                }
            }
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Subject::Name => f.write_str("name"),
            Subject::Key => f.write_str("key"),
            Subject::Parameter(path) => {
                let segments: Vec<String> = path.iter().map(|s| super::parse::segment(s)).collect();
                f.write_str(&segments.join("."))
            }
        }
    }
}
