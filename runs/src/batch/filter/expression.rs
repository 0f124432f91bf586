//! Parsed filter expressions.

use std::fmt;
use std::ops::Range;

use crate::results::ParamValue;

/// An expression over one run.
#[derive(Clone, Debug)]
pub(super) enum Expression {
    /// Two or more operands; one list keeps the tree no deeper than its brackets.
    Any(Vec<Expression>),
    All(Vec<Expression>),
    Not(Box<Expression>),
    /// A comparison and its number in the text, from 0.
    Comparison(usize, Comparison),
}

/// Compares a property of a run with written values.
#[derive(Clone, Debug)]
pub(super) struct Comparison {
    pub subject: Subject,
    pub relation: Relation,
    /// At least one, all of one kind; several only with [`Relation::In`]. Patterns have `\` before
    /// literal characters, as in double quotes.
    pub expected: Vec<ParamValue>,
    /// Range of the subject in the text.
    pub at: Range<usize>,
    /// Range of the right side.
    pub expected_at: Range<usize>,
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

    /// True if it needs numbers.
    pub fn needs_numbers(self) -> bool {
        matches!(self, Relation::Less | Relation::AtMost | Relation::Greater | Relation::AtLeast)
    }

    /// The sign after swapping both sides; none if the relation cannot be swapped.
    pub fn swapped(self) -> Option<&'static str> {
        match self {
            Relation::Equal | Relation::Unequal => Some(self.sign()),
            Relation::Less => Some(">"),
            Relation::AtMost => Some(">="),
            Relation::Greater => Some("<"),
            Relation::AtLeast => Some("<="),
            Relation::Like | Relation::Unlike | Relation::Begins | Relation::In => None,
        }
    }

    /// True if it tests equality.
    pub fn tests_equality(self) -> bool {
        matches!(self, Relation::Equal | Relation::Unequal | Relation::In)
    }

    /// True if it takes a pattern.
    pub fn takes_pattern(self) -> bool {
        matches!(self, Relation::Like | Relation::Unlike)
    }

    /// True if it needs texts.
    pub fn needs_texts(self) -> bool {
        matches!(self, Relation::Like | Relation::Unlike | Relation::Begins)
    }
}

impl Comparison {
    /// True if it compares a parameter with texts, which may be misspelt.
    pub fn names_texts(&self) -> bool {
        let is_text = |value: &ParamValue| matches!(value, ParamValue::Text(_));
        self.relation.tests_equality()
            && matches!(self.subject, Subject::Parameter(_))
            && self.expected.iter().any(is_text)
    }
}

impl Expression {
    /// All comparisons, in the order of the text.
    pub fn comparisons(&self) -> Vec<&Comparison> {
        match self {
            Expression::Any(all) | Expression::All(all) => all.iter().flat_map(Expression::comparisons).collect(),
            Expression::Not(a) => a.comparisons(),
            Expression::Comparison(_, comparison) => vec![comparison],
        }
    }

    /// Evaluates the expression, given the result of each comparison.
    pub fn value(&self, results: &[bool]) -> bool {
        match self {
            Expression::Any(all) => all.iter().any(|one| one.value(results)),
            Expression::All(all) => all.iter().all(|one| one.value(results)),
            Expression::Not(a) => !a.value(results),
            Expression::Comparison(index, _) => results[*index],
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
            Expression::Comparison(_, Comparison { subject, relation, expected, .. }) => {
                let literal = |value: &ParamValue| match value {
                    // Patterns are stored as written in double quotes.
                    ParamValue::Text(pattern) if relation.takes_pattern() => format!("\"{pattern}\""),
                    ParamValue::Text(text) => super::literal::quoted(text),
                    other => other.to_string(),
                };
                let values: Vec<String> = expected.iter().map(literal).collect();
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
                let segments: Vec<String> = path.iter().map(|s| super::literal::segment(s)).collect();
                f.write_str(&segments.join("."))
            }
        }
    }
}
