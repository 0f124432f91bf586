//! A TOML document as a tree in which each key and value has its span in the text.

use std::fmt;

use toml::de::{DeTable, DeValue};

use super::toml_syntax::TomlError;

type Span = std::ops::Range<usize>;

/// Greatest number of errors for which duplicate keys are searched; each search takes as long as
/// parsing the text.
const MAX_SEARCHES: usize = 20;
/// Length of a text, bytes, beyond which no duplicates are searched.
const MAX_SEARCHED_LENGTH: usize = 1 << 20;

/// A value and its span.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its bytes in the sources.
    pub span: Span,
    /// Its value.
    pub value: Value,
}

/// A TOML value whose parts have spans.
#[derive(Clone, Debug)]
pub enum Value {
    /// A string, without quotes and escapes.
    String(String),
    /// A whole number.
    Integer(i64),
    /// A finite number.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or time, as written.
    Datetime(String),
    /// An array.
    Array(Vec<Node>),
    /// A table.
    Table(Vec<Entry>),
}

/// A key of a table with its value; the entries of a table are in the order of the file.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Bytes of the key in the sources.
    pub key_span: Span,
    /// The value.
    pub node: Node,
}

impl Node {
    /// Parses a TOML document that starts at `start` in the sources, and reports syntax errors and
    /// numbers that are not finite. The tree holds all that could be parsed.
    pub fn parse(text: &str, start: usize) -> (Node, Vec<TomlError>) {
        let (document, found) = DeTable::parse_recoverable(text);
        let mut errors = Vec::new();
        for (count, error) in found.iter().enumerate() {
            let find_duplicates = count < MAX_SEARCHES && text.len() < MAX_SEARCHED_LENGTH;
            let error = TomlError::new(error, text, find_duplicates);
            errors.push(TomlError { span: shift(error.span.clone(), start), ..error });
        }
        (Node::of(document.get_ref(), start, &mut errors), errors)
    }

    /// The tree of a parsed document.
    pub(super) fn of(document: &DeTable<'_>, start: usize, errors: &mut Vec<TomlError>) -> Node {
        // A diagnostic about the document as a whole is shown at its start.
        Node { span: start..start, value: table(document, start, errors) }
    }

    /// The path of the innermost key or value at a byte.
    pub fn path_at(&self, byte: usize) -> Option<Vec<String>> {
        let mut best = None;
        narrow(self, &mut Vec::new(), byte, &mut best);
        best.map(|(path, _)| path)
    }

    /// Entries of a table; none of other values.
    pub fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    /// Items of an array; none of other values.
    pub fn items(&self) -> &[Node] {
        match &self.value {
            Value::Array(items) => items,
            _ => &[],
        }
    }

    /// The entry of a table with a key.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries().iter().find(|e| e.key == key)
    }

    /// The value of a key of a table.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|e| &e.node)
    }

    /// The value of a key of a table, to change it.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        let Value::Table(entries) = &mut self.value else { return None };
        entries.iter_mut().find(|e| e.key == key).map(|e| &mut e.node)
    }

    /// Passes bytes to `add` that differ for different values. Spans do not count, the order of
    /// keys does.
    pub fn hash_parts(&self, add: &mut dyn FnMut(&[u8])) {
        let mut part = |kind: u8, bytes: &[u8]| {
            add(&[kind]);
            add(&(bytes.len() as u64).to_le_bytes());
            add(bytes);
        };
        match &self.value {
            Value::String(text) => part(b's', text.as_bytes()),
            Value::Integer(number) => part(b'i', &number.to_le_bytes()),
            Value::Float(number) => part(b'f', &number.to_bits().to_le_bytes()),
            Value::Boolean(yes) => part(b'b', &[u8::from(*yes)]),
            Value::Datetime(text) => part(b'd', text.as_bytes()),
            Value::Array(items) => {
                part(b'a', &(items.len() as u64).to_le_bytes());
                items.iter().for_each(|item| item.hash_parts(add));
            }
            Value::Table(entries) => {
                part(b't', &(entries.len() as u64).to_le_bytes());
                for entry in entries {
                    add(&(entry.key.len() as u64).to_le_bytes());
                    add(entry.key.as_bytes());
                    entry.node.hash_parts(add);
                }
            }
        }
    }

    /// Removes an entry of a table.
    pub fn remove(&mut self, key: &str) -> Option<Entry> {
        let Value::Table(entries) = &mut self.value else { return None };
        let at = entries.iter().position(|e| e.key == key)?;
        Some(entries.remove(at))
    }

    /// The text of a string.
    pub fn as_str(&self) -> Option<&str> {
        match &self.value {
            Value::String(text) => Some(text),
            _ => None,
        }
    }

    /// The value without spans.
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

    /// A table without spans; empty for any other value.
    pub fn to_table(&self) -> toml::Table {
        match self.to_toml() {
            toml::Value::Table(table) => table,
            _ => toml::Table::new(),
        }
    }

    /// A value that is computed from the text at `span`.
    pub fn computed(value: Value, span: &Span) -> Node {
        Node { span: span.clone(), value }
    }
}

/// Describes a value: `the number 1`, `the string "x"`.
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

fn table(source: &DeTable<'_>, start: usize, errors: &mut Vec<TomlError>) -> Value {
    let mut entries: Vec<_> = source
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_span: shift(key.span(), start),
            node: node(value.get_ref(), shift(value.span(), start), start, errors),
        })
        .collect();
    entries.sort_by_key(|e| e.key_span.start);
    Value::Table(entries)
}

fn node(source: &DeValue<'_>, span: Span, start: usize, errors: &mut Vec<TomlError>) -> Node {
    let value = match source {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => {
                let help = Some("whole numbers have at most 64 bits".into());
                errors.push(TomlError { span: span.clone(), message: "this whole number is too large".into(), help });
                Value::Integer(0)
            }
        },
        DeValue::Float(number) => match number.as_str().parse::<f64>() {
            Ok(number) if number.is_finite() => Value::Float(number),
            _ => {
                let message = "every number must be finite".into();
                errors.push(TomlError { span: span.clone(), message, help: None });
                Value::Float(0.0)
            }
        },
        DeValue::Boolean(yes) => Value::Boolean(*yes),
        DeValue::Datetime(time) => Value::Datetime(time.to_string()),
        DeValue::Array(items) => Value::Array(
            items.iter().map(|item| node(item.get_ref(), shift(item.span(), start), start, errors)).collect(),
        ),
        DeValue::Table(entries) => table(entries, start, errors),
    };
    Node { span, value }
}

fn shift(span: Span, start: usize) -> Span {
    span.start + start..span.end + start
}

/// The value of an assignment `a.b = ...` that starts at `start` in the sources and whose key has
/// `depth` segments.
pub fn assigned_value(text: &str, start: usize, depth: usize) -> (Node, Vec<TomlError>) {
    let (mut node, errors) = Node::parse(text, start);
    for _ in 0..depth {
        match node.value {
            Value::Table(mut entries) if entries.len() == 1 => node = entries.remove(0).node,
            _ => break,
        }
    }
    (node, errors)
}

/// Finds the entry with the shortest key or value around a byte; among equal ones the inner one.
fn narrow(node: &Node, path: &mut Vec<String>, at: usize, best: &mut Option<(Vec<String>, usize)>) {
    let mut compare = |path: &mut Vec<String>, node: &Node, spans: &[&Span]| {
        for span in spans.iter().filter(|span| span.start <= at && at < span.end) {
            if best.as_ref().is_none_or(|(_, length)| span.len() <= *length) {
                *best = Some((path.clone(), span.len()));
            }
        }
        narrow(node, path, at, best);
    };
    match &node.value {
        Value::Table(entries) => {
            for entry in entries {
                path.push(entry.key.clone());
                compare(path, &entry.node, &[&entry.key_span, &entry.node.span]);
                path.pop();
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                path.push(index.to_string());
                compare(path, item, &[&item.span]);
                path.pop();
            }
        }
        _ => {}
    }
}
