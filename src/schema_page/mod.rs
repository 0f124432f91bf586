//! Reference pages made of a JSON Schema, and so of the types that read the files: every key with its type, default and
//! meaning, a section for each table.

mod phrase;
mod section;

use std::collections::{BTreeMap, VecDeque};

use serde_json::{Map, Value};

use phrase::Kind;

/// How a format is written down, which decides how a page names its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// `[floor]`, `[[force]]`; a key that has no value is left out.
    Toml,
    /// Lines of JSON, in which a value may be null.
    Json,
}

/// A Markdown page about all that `schema` describes, below the line `heading` and the text `introduction`.
///
/// Sections stand in the order in which their tables are met from the root on; what several keys share has one section.
pub fn page(schema: &Value, notation: Notation, heading: &str, introduction: &str) -> String {
    let empty = Map::new();
    let definitions = schema.get("$defs").and_then(Value::as_object).unwrap_or(&empty);
    let mut page = Page { definitions, notation, variant: None, waiting: VecDeque::new(), met: BTreeMap::new() };
    let mut text = format!("# {heading}\n\n{introduction}\n{}", page.root(schema));
    let mut sections = Vec::new();
    while let Some(place) = page.waiting.pop_front() {
        // What a section leads to follows it at once, before its neighbours.
        let neighbours = std::mem::take(&mut page.waiting);
        sections.push((page.title(&place), page.section(&place), place));
        page.waiting.extend(neighbours);
    }
    for (title, body, place) in &sections {
        // Tables of one name that differ from variant to variant.
        let alike = sections.iter().filter(|(other, ..)| other == title).count();
        let of = place.variant.as_ref().filter(|_| alike > 1).map(|v| format!(" of `{v}`")).unwrap_or_default();
        text.push_str(&format!("\n<a id=\"{}\"></a>\n\n## `{title}`{of}\n\n{body}", anchor(place.name)));
        if let Some([_, others @ ..]) = page.met.get(place.name).map(Vec::as_slice).filter(|places| places.len() > 1) {
            text.push_str(&format!("\nAlso at {}.\n", others.join(", ")));
        }
    }
    text
}

/// A page that is being written.
struct Page<'a> {
    definitions: &'a Map<String, Value>,
    notation: Notation,
    /// Tables that were met and have no section yet.
    waiting: VecDeque<Place<'a>>,
    /// The variant of a tagged table that is being written about: `type = "push"`.
    variant: Option<String>,
    /// Where each definition was met, by its name.
    met: BTreeMap<&'a str, Vec<String>>,
}

/// Something that gets a section of its own, and where in the file it was met first.
struct Place<'a> {
    name: &'a str,
    node: &'a Value,
    path: String,
    variant: Option<String>,
}

impl<'a> Page<'a> {
    /// What a reference points to.
    fn target(&self, node: &'a Value) -> Option<(&'a str, &'a Value)> {
        let name = node.get("$ref")?.as_str()?.strip_prefix("#/$defs/")?;
        let (name, target) = self.definitions.get_key_value(name)?;
        Some((name, target))
    }

    /// Sees to it that a definition has a section, and notes where it was met.
    fn meet(&mut self, name: &'a str, node: &'a Value, path: &str) {
        let shown = format!("`{}`", self.header(path));
        let places = self.met.entry(name).or_default();
        if places.is_empty() {
            self.waiting.push_back(Place { name, node, path: path.to_string(), variant: self.variant.clone() });
        }
        if !places.contains(&shown) {
            places.push(shown);
        }
    }

    /// A path as a file would name it: `floor.friction`, and where a table of an array is meant, `[[force]]`.
    fn header(&self, path: &str) -> String {
        let plain = path.replace("[]", "");
        match (self.notation, path.strip_suffix("[]")) {
            (Notation::Toml, Some(_)) => format!("[[{plain}]]"),
            _ => plain,
        }
    }

    /// The heading of a section.
    fn title(&self, place: &Place) -> String {
        let header = self.header(&place.path);
        let table = matches!(Kind::of(place.node), Kind::Table | Kind::Tagged);
        if self.notation == Notation::Toml && table && !header.starts_with('[') {
            format!("[{header}]")
        } else {
            header
        }
    }
}

/// The name by which links find a section.
fn anchor(name: &str) -> String {
    let mut anchor = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !anchor.is_empty() {
            anchor.push('-');
        }
        anchor.push(c.to_ascii_lowercase());
    }
    anchor
}

/// Descriptions are wrapped in the source; on a page they are one line.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn description(node: &Value) -> String {
    node.get("description").and_then(Value::as_str).map(one_line).unwrap_or_default()
}

/// Alternatives, however the schema says it.
fn alternatives(node: &Value) -> Option<&Vec<Value>> {
    node.get("oneOf").or_else(|| node.get("anyOf"))?.as_array()
}

/// Is it the schema's way to say that a value may be missing?
fn is_null(node: &Value) -> bool {
    node.get("type").and_then(Value::as_str) == Some("null")
}
