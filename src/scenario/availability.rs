//! What the file format knows and this version cannot do yet. Each is an error at its place, never ignored.
//!
//! To make something available, add its variant or its reader and delete its line here.

use super::{
    diagnostic::Findings,
    tree::{Node, Value},
};

/// A place (a dotted path, `*` for every entry of an array or table) and the word there that is not available; no word
/// means that the place itself may not be given.
const PLANNED: &[(&str, Option<&str>)] = &[("self_collision", None)];

/// Is this type of entry (`kind` is `task` or `force`) known but not available.
pub fn is_planned(kind: &str, type_name: &str) -> bool {
    PLANNED.contains(&(format!("{kind}.*.type").as_str(), Some(type_name)))
}

/// Report all that is given but not available.
pub fn check(root: &Node, findings: &mut Findings) {
    for (place, word) in PLANNED {
        let segments: Vec<&str> = place.split('.').collect();
        walk(root, &segments, &mut Vec::new(), *word, findings);
    }
}

fn walk(node: &Node, rest: &[&str], path: &mut Vec<String>, word: Option<&str>, findings: &mut Findings) {
    let Some((segment, rest)) = rest.split_first() else {
        if let Some(word) = word
            && node.as_str() == Some(word)
        {
            findings.error(node.span.clone(), message(path, word), None);
        }
        return;
    };
    let mut visit = |key: String, span: &super::source::Span, node: &Node| {
        path.push(key);
        if rest.is_empty() && word.is_none() && !is_empty(node) {
            findings.error(span.clone(), format!("`{}` is not available yet", path.join(".")), None);
        } else {
            walk(node, rest, path, word, findings);
        }
        path.pop();
    };
    for entry in node.entries().iter().filter(|e| *segment == "*" || e.key == *segment) {
        visit(entry.key.clone(), &entry.key_span, &entry.node);
    }
    if *segment == "*" {
        for (i, item) in node.items().iter().enumerate() {
            visit(i.to_string(), &item.span, item);
        }
    }
}

fn message(path: &[String], word: &str) -> String {
    match (path.first().map(String::as_str), path.last().map(String::as_str)) {
        (Some(kind), Some("type")) => format!("{kind} type `{word}` is not available yet"),
        _ => format!("{} `{word}` is not available yet", path.join(".")),
    }
}

/// An empty array asks for nothing.
fn is_empty(node: &Node) -> bool {
    matches!(&node.value, Value::Array(items) if items.is_empty())
}
