//! Writes sections: tables of keys, lists of values with meanings, variants of tagged tables, and
//! alternative forms.

use serde_json::Value;

use crate::schema_page::page_context::{Notation, Page, SectionEntry};
use crate::schema_page::schema_node::{Kind, alternatives, description, quoted, tag};
use crate::schema_page::type_phrase::MAX_INLINE;

impl<'a> Page<'a> {
    /// Writes the section of the top level.
    pub fn root(&mut self, schema: &'a Value) -> String {
        let mut text = format!("\n## Top level\n\n{}", self.keys(schema, ""));
        if schema.get("oneOf").is_some() {
            text.push_str(&self.variants(schema, "", "##"));
        }
        text
    }

    /// Writes the text below the heading of a section.
    pub fn section(&mut self, entry: &SectionEntry<'a>) -> String {
        let SectionEntry { node, path, .. } = entry;
        let body = match Kind::of(node) {
            Kind::Table => self.keys(node, path),
            Kind::Values => self.values(node),
            Kind::Tagged => self.variants(node, path, "###"),
            Kind::Forms | Kind::Plain => self.forms(node, path),
        };
        format!("{}\n{}{body}", description(node), if body.starts_with('\n') { "" } else { "\n" })
    }

    /// Writes a table with a row for each key.
    fn keys(&mut self, node: &'a Value, path: &str) -> String {
        let Some(properties) = node.get("properties").and_then(Value::as_object) else { return String::new() };
        let required: Vec<&str> =
            node.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect();
        let defaults = self.notation == Notation::Toml;
        let mut text = String::from(if defaults {
            "| key | type | default | meaning |\n|---|---|---|---|\n"
        } else {
            "| key | type | meaning |\n|---|---|---|\n"
        });
        let mut lists = String::new();
        // The heading of a variant shows its tag.
        let tag = tag(node).map(|(key, _)| key);
        for (key, value) in properties.iter().filter(|(key, _)| Some(key.as_str()) != tag) {
            let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let phrase = cell(&self.phrase(value, &below));
            let default = match value.get("default") {
                _ if required.contains(&key.as_str()) => "required".to_string(),
                Some(default) if !self.repeats_key_defaults(value, default) => cell(&quoted(default)),
                _ => String::new(),
            };
            let default = if defaults { format!(" {default} |") } else { String::new() };
            text.push_str(&format!("| `{key}` | {phrase} |{default} {} |\n", cell(&description(value))));
            lists.push_str(&long_lists(key, value));
        }
        text + &lists
    }

    /// True if the default of a table equals the defaults of its keys.
    fn repeats_key_defaults(&self, value: &'a Value, default: &Value) -> bool {
        let (Some((_, target)), Some(default)) = (self.target(value), default.as_object()) else { return false };
        default.iter().all(|(key, value)| {
            let own = target.get("properties").and_then(|p| p.get(key));
            own.is_some_and(|own| {
                own.get("default") == Some(value)
                    || value.is_null()
                    || (own.get("default").is_none() && matches!(value, Value::Array(a) if a.is_empty()))
            })
        })
    }

    /// Writes a table of values and their meanings.
    fn values(&mut self, node: &'a Value) -> String {
        let mut text = String::from("| value | meaning |\n|---|---|\n");
        for choice in alternatives(node).into_iter().flatten() {
            let value = choice.get("const").map(quoted).unwrap_or_default();
            text.push_str(&format!("| {value} | {} |\n", cell(&description(choice))));
        }
        text
    }

    /// Writes a part for each variant of a tagged table.
    fn variants(&mut self, node: &'a Value, path: &str, level: &str) -> String {
        let mut text = String::new();
        for variant in alternatives(node).into_iter().flatten() {
            let Some((key, value)) = tag(variant) else { continue };
            let title = match self.notation {
                Notation::Toml => format!("{key} = \"{value}\""),
                Notation::Json => format!("\"{key}\": \"{value}\""),
            };
            // Tasks and forces have variants of the same names.
            let of = if path.is_empty() { String::new() } else { format!("`{}` with ", self.header(path)) };
            text.push_str(&format!("\n{level} {of}`{title}`\n\n{}\n\n", description(variant)));
            self.variant = Some(title);
            // The keys of a variant may be in a definition of their own.
            match self.target(variant) {
                Some((_, target)) => text.push_str(&self.keys(target, path)),
                None => text.push_str(&self.keys(variant, path)),
            }
        }
        self.variant = None;
        text
    }

    /// Writes a list of alternative forms.
    fn forms(&mut self, node: &'a Value, path: &str) -> String {
        let mut text = String::new();
        for form in alternatives(node).into_iter().flatten() {
            let phrase = self.phrase(form, path);
            let meaning = description(form);
            let gap = if meaning.is_empty() { "" } else { ": " };
            text.push_str(&format!("- {phrase}{gap}{meaning}\n"));
        }
        text
    }
}

/// Lists of values that are too long for the row of their key.
fn long_lists(key: &str, value: &Value) -> String {
    let nodes = std::iter::once(value).chain(alternatives(value).into_iter().flatten());
    let nodes = nodes.chain(value.get("propertyNames"));
    let mut text = String::new();
    for names in nodes.filter_map(|node| node.get("enum")?.as_array()).filter(|names| names.len() > MAX_INLINE) {
        let names: Vec<_> = names.iter().map(quoted).collect();
        text.push_str(&format!("\nNames for `{key}`: {}.\n", names.join(", ")));
    }
    text
}

/// Escapes text for a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use crate::schema_page::{Notation, page};

    /// An unescaped bar would shift the rest of the row to the next columns.
    #[test]
    fn bars_in_texts_are_escaped() {
        let schema = serde_json::json!({
            "properties": { "mode": { "enum": ["a|b", "c"], "default": "a|b", "description": "one | or the other" } }
        });
        let text = page(&schema, Notation::Toml, "Formats", "");
        let line = text.lines().find(|line| line.contains("`mode`")).unwrap();
        assert_eq!(line, r#"| `mode` | `"a\|b"`, `"c"` | `"a\|b"` | one \| or the other |"#);
    }
}
