//! Literals and path segments of filters as text, and the kinds of values.

use crate::results::ParamValue;

/// A path segment, in quotes unless it is a bare word other than a keyword.
pub(super) fn segment(name: &str) -> String {
    let is_word = !name.is_empty() && name.chars().all(is_bare);
    if is_word && !["not", "name", "key"].contains(&name) { name.to_owned() } else { quoted(name) }
}

/// A quoted text: verbatim in single quotes, else escaped in double quotes.
pub(super) fn quoted(text: &str) -> String {
    if text.contains('"') && !text.contains('\'') {
        return format!("'{text}'");
    }
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Name of a value's kind, for messages.
pub(super) fn kind(value: &ParamValue) -> &'static str {
    match value {
        ParamValue::Integer(_) | ParamValue::Number(_) => "a number",
        ParamValue::Flag(_) => "true or false",
        ParamValue::Text(_) => "a text",
    }
}

pub(super) fn same_kind(a: &ParamValue, b: &ParamValue) -> bool {
    kind(a) == kind(b)
}

pub(super) fn is_bare(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '-'
}
