//! A TOML document as a tree in which every key and value remembers where it was written.

use std::fmt;

use toml::de::{DeTable, DeValue};

use super::{diagnostic::Findings, source::Span};
use crate::text::toml_syntax;

/// Mistakes of a file that are looked into.
const MOST_LOOKED_FOR: usize = 20;
/// Bytes of a text beyond which none is looked for.
const LONGEST_LOOKED_THROUGH: usize = 1 << 20;

/// A value and its place.
#[derive(Clone, Debug)]
pub struct Node {
    pub span: Span,
    pub value: Value,
}

/// A TOML value whose parts know their places.
#[derive(Clone, Debug)]
pub enum Value {
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime(String),
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table with its value; the entries of a table are in the order of the file.
#[derive(Clone, Debug)]
pub struct Entry {
    pub key: String,
    pub key_span: Span,
    pub node: Node,
}

impl Node {
    /// Read a TOML document that stands at `start` in the sources.
    ///
    /// Syntax errors, and numbers that are no numbers, are added to `findings`; what could be read is returned.
    pub fn parse(text: &str, start: usize, findings: &mut Findings) -> Node {
        let (document, errors) = DeTable::parse_recoverable(text);
        for (count, error) in errors.iter().enumerate() {
            // To look for keys that are there twice takes as long as reading the file does, each time.
            let toml_syntax::Mistake { piece, message, help } =
                toml_syntax::mistake(error, text, count < MOST_LOOKED_FOR && text.len() < LONGEST_LOOKED_THROUGH);
            findings.error(start + piece.start..start + piece.end, message, help);
        }
        let value = table(document.get_ref(), start, findings);
        // The document as a whole is shown at its start.
        Node { span: start..start, value }
    }

    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    pub fn items(&self) -> &[Node] {
        match &self.value {
            Value::Array(items) => items,
            _ => &[],
        }
    }

    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries().iter().find(|e| e.key == key)
    }

    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|e| &e.node)
    }

    /// Take an entry out of a table.
    pub fn remove(&mut self, key: &str) -> Option<Entry> {
        let Value::Table(entries) = &mut self.value else { return None };
        let at = entries.iter().position(|e| e.key == key)?;
        Some(entries.remove(at))
    }

    pub fn as_str(&self) -> Option<&str> {
        match &self.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// The value without its places.
    pub fn to_toml(&self) -> toml::Value {
        match &self.value {
            Value::String(text) => toml::Value::String(text.clone()),
            Value::Integer(number) => toml::Value::Integer(*number),
            Value::Float(number) => toml::Value::Float(*number),
            Value::Boolean(yes) => toml::Value::Boolean(*yes),
            Value::Datetime(text) => {
                text.parse().map_or_else(|_| toml::Value::String(text.clone()), toml::Value::Datetime)
            }
            Value::Array(items) => toml::Value::Array(items.iter().map(Node::to_toml).collect()),
            Value::Table(entries) => {
                toml::Value::Table(entries.iter().map(|e| (e.key.clone(), e.node.to_toml())).collect())
            }
        }
    }

    /// A value that was not written itself but made from what stands at `span`.
    pub fn made(value: Value, span: &Span) -> Node {
        Node { span: span.clone(), value }
    }
}

/// What a value is, in words: `a number`, `the string "x"`.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::String(text) => write!(f, "the string {text:?}"),
            Value::Integer(number) => write!(f, "the number {number}"),
            Value::Float(number) => write!(f, "the number {number:?}"),
            Value::Boolean(yes) => write!(f, "`{yes}`"),
            Value::Datetime(time) => write!(f, "the date or time {time}"),
            Value::Array(_) => write!(f, "an array"),
            Value::Table(_) => write!(f, "a table"),
        }
    }
}

fn table(source: &DeTable<'_>, start: usize, findings: &mut Findings) -> Value {
    let mut entries: Vec<_> = source
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_span: shift(key.span(), start),
            node: node(value.get_ref(), shift(value.span(), start), start, findings),
        })
        .collect();
    entries.sort_by_key(|e| e.key_span.start);
    Value::Table(entries)
}

fn node(source: &DeValue<'_>, span: Span, start: usize, findings: &mut Findings) -> Node {
    let value = match source {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => {
                findings.error(span.clone(), "this whole number is too large", Some("64 bits are kept".into()));
                Value::Integer(0)
            }
        },
        DeValue::Float(number) => match number.as_str().parse::<f64>() {
            Ok(number) if number.is_finite() => Value::Float(number),
            _ => {
                findings.error(span.clone(), "every number must be finite", None);
                Value::Float(0.0)
            }
        },
        DeValue::Boolean(yes) => Value::Boolean(*yes),
        DeValue::Datetime(time) => Value::Datetime(time.to_string()),
        DeValue::Array(items) => Value::Array(
            items.iter().map(|item| node(item.get_ref(), shift(item.span(), start), start, findings)).collect(),
        ),
        DeValue::Table(entries) => table(entries, start, findings),
    };
    Node { span, value }
}

fn shift(span: Span, start: usize) -> Span {
    span.start + start..span.end + start
}

/// The value of an assignment `a.b = ...` that stands at `start` in the sources, its key having `depth` segments.
pub fn assigned(text: &str, start: usize, depth: usize, findings: &mut Findings) -> Node {
    let mut node = Node::parse(text, start, findings);
    for _ in 0..depth {
        match node.value {
            Value::Table(mut entries) if entries.len() == 1 => node = entries.remove(0).node,
            _ => break,
        }
    }
    node
}
