//! Sections: a table of keys, words and what they mean, forms of one thing.

use serde_json::Value;

use super::phrase::{MANY, quoted, tag};
use super::{Kind, Notation, Page, Place, alternatives, description};

impl<'a> Page<'a> {
    /// What a file or a line has at its top.
    pub fn root(&mut self, schema: &'a Value) -> String {
        let mut text = format!("\n## Top level\n\n{}", self.keys(schema, ""));
        if schema.get("oneOf").is_some() {
            text.push_str(&self.variants(schema, "", "##"));
        }
        text
    }

    /// What stands below a section's heading.
    pub fn section(&mut self, place: &Place<'a>) -> String {
        let Place { node, path, .. } = place;
        let body = match Kind::of(node) {
            Kind::Table => self.keys(node, path),
            Kind::Words => self.words(node),
            Kind::Tagged => self.variants(node, path, "###"),
            Kind::Forms | Kind::Plain => self.forms(node, path),
        };
        format!("{}\n{}{body}", description(node), if body.starts_with('\n') { "" } else { "\n" })
    }

    /// A line for each key.
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
        // The word of a variant is its heading already.
        let word = tag(node).map(|(key, _)| key);
        for (key, value) in properties.iter().filter(|(key, _)| Some(key.as_str()) != word) {
            let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let said = cell(&self.phrase(value, &below));
            let default = match value.get("default") {
                _ if required.contains(&key.as_str()) => "required".to_string(),
                Some(default) if !self.is_each_keys_own(value, default) => cell(&quoted(default)),
                _ => String::new(),
            };
            let default = if defaults { format!(" {default} |") } else { String::new() };
            text.push_str(&format!("| `{key}` | {said} |{default} {} |\n", cell(&description(value))));
            lists.push_str(&long_lists(key, value));
        }
        text + &lists
    }

    /// Is a table's default what its keys have by themselves when it is left out?
    fn is_each_keys_own(&self, value: &'a Value, default: &Value) -> bool {
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

    fn words(&mut self, node: &'a Value) -> String {
        let mut text = String::from("| value | meaning |\n|---|---|\n");
        for word in alternatives(node).into_iter().flatten() {
            let value = word.get("const").map(quoted).unwrap_or_default();
            text.push_str(&format!("| {value} | {} |\n", cell(&description(word))));
        }
        text
    }

    /// A part for each word that a tagged table may say.
    fn variants(&mut self, node: &'a Value, path: &str, level: &str) -> String {
        let mut text = String::new();
        for variant in alternatives(node).into_iter().flatten() {
            let Some((key, word)) = tag(variant) else { continue };
            let title = match self.notation {
                Notation::Toml => format!("{key} = \"{word}\""),
                Notation::Json => format!("\"{key}\": \"{word}\""),
            };
            // Tasks and forces have types of the same names.
            let of = if path.is_empty() { String::new() } else { format!("`{}` with ", self.header(path)) };
            text.push_str(&format!("\n{level} {of}`{title}`\n\n{}\n\n", description(variant)));
            self.variant = Some(title);
            // What the table of one variant holds may stand in a definition of its own.
            match self.target(variant) {
                Some((_, target)) => text.push_str(&self.keys(target, path)),
                None => text.push_str(&self.keys(variant, path)),
            }
        }
        self.variant = None;
        text
    }

    fn forms(&mut self, node: &'a Value, path: &str) -> String {
        let mut text = String::new();
        for form in alternatives(node).into_iter().flatten() {
            let said = self.phrase(form, path);
            let meaning = description(form);
            let gap = if meaning.is_empty() { "" } else { ": " };
            text.push_str(&format!("- {said}{gap}{meaning}\n"));
        }
        text
    }
}

/// Words of a key that are too many for its line.
fn long_lists(key: &str, value: &Value) -> String {
    let nodes = std::iter::once(value).chain(alternatives(value).into_iter().flatten());
    let nodes = nodes.chain(value.get("propertyNames"));
    let mut text = String::new();
    for words in nodes.filter_map(|node| node.get("enum")?.as_array()).filter(|words| words.len() > MANY) {
        let words: Vec<_> = words.iter().map(quoted).collect();
        text.push_str(&format!("\nNames for `{key}`: {}.\n", words.join(", ")));
    }
    text
}

/// Text that stands in a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use crate::schema_page::{Notation, page};

    /// Else a line has a cell too many, and all after the bar stands under the wrong heading.
    #[test]
    fn bars_in_texts_end_no_cell() {
        let schema = serde_json::json!({
            "properties": { "mode": { "enum": ["a|b", "c"], "default": "a|b", "description": "one | or the other" } }
        });
        let text = page(&schema, Notation::Toml, "Formats", "");
        let line = text.lines().find(|line| line.contains("`mode`")).unwrap();
        assert_eq!(line, r#"| `mode` | `"a\|b"`, `"c"` | `"a\|b"` | one \| or the other |"#);
    }
}
