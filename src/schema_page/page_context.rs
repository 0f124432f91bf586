//! The state of a reference page while it is written: definitions, pending sections and their
//! references.

use crate::schema_page::schema_node::Kind;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, VecDeque};

/// Notation of a format, which determines how a page names its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// `[floor]`, `[[force]]`; a key without value is omitted.
    Toml,
    /// Lines of JSON; a value may be null.
    Json,
}

/// A page while it is written.
pub(super) struct Page<'a> {
    pub definitions: &'a Map<String, Value>,
    pub notation: Notation,
    /// Referenced definitions that have no section yet.
    pub waiting: VecDeque<SectionEntry<'a>>,
    /// The variant of a tagged table that is being described: `type = "push"`.
    pub variant: Option<String>,
    /// Paths that refer to each definition, by its name.
    pub references: BTreeMap<&'a str, Vec<String>>,
}

/// A definition with its own section, and the first path that refers to it.
pub(super) struct SectionEntry<'a> {
    pub name: &'a str,
    pub node: &'a Value,
    pub path: String,
    pub variant: Option<String>,
}

impl<'a> Page<'a> {
    /// The definition that a reference points to.
    pub fn target(&self, node: &'a Value) -> Option<(&'a str, &'a Value)> {
        let name = node.get("$ref")?.as_str()?.strip_prefix("#/$defs/")?;
        let (name, target) = self.definitions.get_key_value(name)?;
        Some((name, target))
    }

    /// Schedules the section of a definition and records the path that refers to it.
    pub fn reference(&mut self, name: &'a str, node: &'a Value, path: &str) {
        let reference = format!("`{}`", self.header(path));
        let paths = self.references.entry(name).or_default();
        if paths.is_empty() {
            self.waiting.push_back(SectionEntry { name, node, path: path.to_string(), variant: self.variant.clone() });
        }
        if !paths.contains(&reference) {
            paths.push(reference);
        }
    }

    /// A path in the notation of the format: `floor.friction`, or `[[force]]` for a table of an
    /// array.
    pub fn header(&self, path: &str) -> String {
        let plain = path.replace("[]", "");
        match (self.notation, path.strip_suffix("[]")) {
            (Notation::Toml, Some(_)) => format!("[[{plain}]]"),
            _ => plain,
        }
    }

    /// The heading of a section.
    pub fn title(&self, entry: &SectionEntry) -> String {
        let header = self.header(&entry.path);
        let table = matches!(Kind::of(entry.node), Kind::Table | Kind::Tagged);
        if self.notation == Notation::Toml && table && !header.starts_with('[') {
            format!("[{header}]")
        } else {
            header
        }
    }
}
