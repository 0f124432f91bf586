//! Values of a scenario that a world file gives.

use crate::text::source::Span;
use crate::text::toml_tree::{Entry, Node, Value};

pub(super) fn text(text: &str, span: &Span) -> Node {
    Node { span: span.clone(), value: Value::String(text.to_owned()) }
}

pub(super) fn number(x: f64, span: &Span) -> Node {
    Node { span: span.clone(), value: Value::Float(x) }
}

pub(super) fn truth(yes: bool, span: &Span) -> Node {
    Node { span: span.clone(), value: Value::Boolean(yes) }
}

pub(super) fn numbers(list: &[f64], span: &Span) -> Node {
    Node { span: span.clone(), value: Value::Array(list.iter().map(|x| number(*x, span)).collect()) }
}

pub(super) fn table(entries: Vec<(&str, Node)>, span: &Span) -> Node {
    let entry = |(key, node): (&str, Node)| Entry { key: key.to_owned(), key_span: node.span.clone(), node };
    Node { span: span.clone(), value: Value::Table(entries.into_iter().map(entry).collect()) }
}
