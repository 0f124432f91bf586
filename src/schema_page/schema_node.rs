//! Reads nodes of a JSON Schema: their kind, alternatives, tag and description.

use serde_json::Value;

/// Kind of a definition, which determines its presentation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A table with keys.
    Table,
    /// Values, each with its meaning.
    Values,
    /// Tables that are distinguished by the value of one key.
    Tagged,
    /// Alternative forms of one value.
    Forms,
    /// A type without a section, described in place.
    Plain,
}

impl Kind {
    pub fn of(node: &Value) -> Kind {
        if node.get("properties").is_some() && node.get("oneOf").is_none() {
            return Kind::Table;
        }
        match alternatives(node) {
            Some(all) if all.iter().all(|a| a.get("const").is_some()) => Kind::Values,
            Some(all) if all.iter().all(|a| tag(a).is_some()) => Kind::Tagged,
            Some(all) if all.iter().any(|a| a.get("properties").is_some() || a.get("description").is_some()) => {
                Kind::Forms
            }
            _ => Kind::Plain,
        }
    }
}

/// The key and the value that distinguish a table.
pub(super) fn tag(node: &Value) -> Option<(&str, &str)> {
    let properties = node.get("properties")?.as_object()?;
    properties.iter().find_map(|(key, value)| Some((key.as_str(), value.get("const")?.as_str()?)))
}

/// The anchor of a section in links.
pub(super) fn anchor(name: &str) -> String {
    let mut anchor = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !anchor.is_empty() {
            anchor.push('-');
        }
        anchor.push(c.to_ascii_lowercase());
    }
    anchor
}

/// Joins the lines of a description, which are wrapped in the source.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(super) fn description(node: &Value) -> String {
    node.get("description").and_then(Value::as_str).map(one_line).unwrap_or_default()
}

/// The alternatives of `oneOf` or `anyOf`.
pub(super) fn alternatives(node: &Value) -> Option<&Vec<Value>> {
    node.get("oneOf").or_else(|| node.get("anyOf"))?.as_array()
}

/// True for the type `null`.
pub(super) fn is_null(node: &Value) -> bool {
    node.get("type").and_then(Value::as_str) == Some("null")
}

/// A value in its notation, marked as code.
pub(super) fn quoted(value: &Value) -> String {
    format!("`{}`", typed(value))
}

/// A value in its notation; TOML and JSON differ in tables only.
pub(super) fn typed(value: &Value) -> String {
    match value {
        Value::Object(table) if table.is_empty() => "{}".into(),
        Value::Object(table) => {
            let keys: Vec<_> = table.iter().map(|(key, value)| format!("{key} = {}", typed(value))).collect();
            format!("{{ {} }}", keys.join(", "))
        }
        Value::Array(items) => format!("[{}]", items.iter().map(typed).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}
