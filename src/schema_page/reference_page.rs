//! Assembles a reference page from its sections.

use crate::schema_page::page_context::{Notation, Page};
use crate::schema_page::schema_node::anchor;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, VecDeque};

/// Writes a Markdown page on the format that `schema` describes, with a heading and an
/// introduction.
///
/// Sections are in the order of references from the root. A definition that several keys share has
/// one section.
pub fn page(schema: &Value, notation: Notation, heading: &str, introduction: &str) -> String {
    let empty = Map::new();
    let definitions = schema.get("$defs").and_then(Value::as_object).unwrap_or(&empty);
    let mut page = Page { definitions, notation, variant: None, waiting: VecDeque::new(), references: BTreeMap::new() };
    let mut text = format!("# {heading}\n\n{introduction}\n{}", page.root(schema));
    let mut sections = Vec::new();
    while let Some(entry) = page.waiting.pop_front() {
        // Definitions that a section refers to follow it, before its siblings.
        let siblings = std::mem::take(&mut page.waiting);
        sections.push((page.title(&entry), page.section(&entry), entry));
        page.waiting.extend(siblings);
    }
    for (title, body, entry) in &sections {
        // Tables of one name may differ between variants.
        let alike = sections.iter().filter(|(other, ..)| other == title).count();
        let of = entry.variant.as_ref().filter(|_| alike > 1).map(|v| format!(" of `{v}`")).unwrap_or_default();
        text.push_str(&format!("\n<a id=\"{}\"></a>\n\n## `{title}`{of}\n\n{body}", anchor(entry.name)));
        if let Some([_, others @ ..]) =
            page.references.get(entry.name).map(Vec::as_slice).filter(|paths| paths.len() > 1)
        {
            text.push_str(&format!("\nAlso at {}.\n", others.join(", ")));
        }
    }
    text
}
