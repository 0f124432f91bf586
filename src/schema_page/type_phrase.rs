//! Describes types: `number >= 0`, `array of 3: number`, a link to the section of a table.

use serde_json::Value;

use crate::schema_page::page_context::{Notation, Page};
use crate::schema_page::schema_node::{Kind, alternatives, anchor, is_null, quoted};

impl<'a> Page<'a> {
    /// Describes the type of a value; `path` is recorded in the sections of the tables that it
    /// refers to.
    pub fn phrase(&mut self, node: &'a Value, path: &str) -> String {
        if let Some((name, target)) = self.target(node) {
            return match Kind::of(target) {
                Kind::Plain => self.phrase(target, path),
                kind => {
                    self.reference(name, target, path);
                    let link = format!("(#{})", anchor(name));
                    match (kind, alternatives(target)) {
                        (Kind::Values, Some(choices)) => {
                            let values: Vec<_> = choices.iter().filter_map(|c| c.get("const")).map(quoted).collect();
                            format!("[{}]{link}", values.join(", "))
                        }
                        (Kind::Forms, _) => format!("[see there]{link}"),
                        _ => format!("[table]{link}"),
                    }
                }
            };
        }
        if let Some(all) = alternatives(node) {
            let nulls = self.notation == Notation::Json;
            let phrases: Vec<_> = all.iter().filter(|a| nulls || !is_null(a)).map(|a| self.phrase(a, path)).collect();
            return phrases.join(" or ");
        }
        if let Some(value) = node.get("const") {
            return quoted(value);
        }
        if let Some(values) = node.get("enum").and_then(Value::as_array) {
            return if values.len() > MAX_INLINE {
                "one of the names below".into()
            } else {
                values.iter().map(quoted).collect::<Vec<_>>().join(", ")
            };
        }
        let (types, nullable) = types(node);
        let phrases: Vec<String> = types.iter().map(|t| self.of_type(t, node, path)).collect();
        let null = if nullable && self.notation == Notation::Json { " or null" } else { "" };
        match phrases.join(" or ") {
            phrase if phrase.is_empty() && node.get("pattern").is_some() => {
                format!("one that matches {}", code(node, "pattern"))
            }
            phrase if phrase.is_empty() && nullable => "null".into(),
            phrase if phrase.is_empty() => "any value".into(),
            phrase => format!("{phrase}{null}"),
        }
    }

    fn of_type(&mut self, name: &str, node: &'a Value, path: &str) -> String {
        match name {
            "array" => self.array(node, path),
            "object" => self.object(node, path),
            "string" => match node.get("examples").and_then(|e| e.get(0)) {
                Some(example) => format!("string such as {}", quoted(example)),
                None if node.get("minLength").is_some() => "string, not empty".into(),
                None => "string".into(),
            },
            "number" | "integer" => format!("{name}{}", bounds(node)),
            other => other.into(),
        }
    }

    fn array(&mut self, node: &'a Value, path: &str) -> String {
        let inside = format!("{path}[]");
        if let Some(items) = node.get("prefixItems").and_then(Value::as_array) {
            let items: Vec<_> = items.iter().map(|item| self.phrase(item, &inside)).collect();
            return format!("[{}]", items.join(", "));
        }
        let number = |key: &str| node.get(key).and_then(Value::as_u64);
        let count = match (number("minItems"), number("maxItems")) {
            (Some(least), Some(most)) if least == most => format!(" of {least}"),
            (Some(least), Some(most)) => format!(" of {least} to {most}"),
            (Some(least), None) => format!(" of at least {least}"),
            _ => String::new(),
        };
        let items = node.get("items").map(|items| self.phrase(items, &inside)).unwrap_or_else(|| "any value".into());
        format!("array{count}: {items}")
    }

    fn object(&mut self, node: &'a Value, path: &str) -> String {
        if let Some(properties) = node.get("properties").and_then(Value::as_object) {
            let mut keys = Vec::new();
            for (key, value) in properties {
                keys.push(format!("`{key}`: {}", self.phrase(value, &format!("{path}.{key}"))));
            }
            if let Some(values) = node.get("additionalProperties").filter(|v| v.is_object()) {
                keys.push(format!("`NAME`: {}", self.phrase(values, &format!("{path}.NAME"))));
            }
            return format!("table of {}", keys.join("; "));
        }
        match node.get("additionalProperties") {
            Some(values) if values.is_object() => {
                format!("table of `NAME`: {}", self.phrase(values, &format!("{path}.NAME")))
            }
            _ => "table of `NAME`: any value".into(),
        }
    }
}

/// Longest list of values within a row; longer ones follow the table.
pub(super) const MAX_INLINE: usize = 8;

/// The types of a value, and whether it may be null.
fn types(node: &Value) -> (Vec<&str>, bool) {
    let all: Vec<&str> = match node.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(several)) => several.iter().filter_map(Value::as_str).collect(),
        _ => vec![],
    };
    let nullable = all.contains(&"null");
    (all.into_iter().filter(|t| *t != "null").collect(), nullable)
}

fn bounds(node: &Value) -> String {
    let bound = |key: &str| node.get(key).map(ToString::to_string);
    let mut bounds = Vec::new();
    for (key, sign) in [("minimum", ">="), ("exclusiveMinimum", ">"), ("maximum", "<="), ("exclusiveMaximum", "<")] {
        if let Some(bound) = bound(key) {
            bounds.push(format!("{sign} {bound}"));
        }
    }
    if let Some(step) = bound("multipleOf") {
        bounds.push(format!("a multiple of {step}"));
    }
    if bounds.is_empty() { String::new() } else { format!(" {}", bounds.join(", ")) }
}

fn code(node: &Value, key: &str) -> String {
    format!("`{}`", node.get(key).and_then(Value::as_str).unwrap_or_default())
}
