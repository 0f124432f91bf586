//! Dotted paths into a scenario, `floor.friction` or `force.0.force`, as sweeps and overrides use
//! them.
//!
//! A path is written like a dotted key of TOML, so a name that contains a dot is quoted.

use toml::de::{DeTable, DeValue};

use crate::text::source::{Sources, Span};
use crate::text::toml_tree::{Entry, Node, Value};

/// A path whose segments have spans.
#[derive(Clone, Debug)]
pub struct KeyPath {
    /// Keys and indices, outermost first.
    pub segments: Vec<(String, Span)>,
}

/// Why a path cannot be parsed or followed.
pub struct PathError {
    pub span: Span,
    pub message: String,
}

impl KeyPath {
    /// Parses a path that is written at `span` in the sources, quoted or not.
    pub fn parse(text: &str, span: &Span, sources: &Sources) -> Result<KeyPath, PathError> {
        let bad = || PathError { span: span.clone(), message: format!("`{text}` is not a dotted path") };
        if text.contains(['\n', '\r']) {
            return Err(bad());
        }
        let document = format!("{text} = 0");
        let table = DeTable::parse(&document).map_err(|_| bad())?;
        // If escapes in quotes shift the offsets, each segment gets the whole span.
        let origin = sources.slice(span).find(text).map(|i| span.start + i);
        let shifted = |at: Span| origin.map_or_else(|| span.clone(), |o| o + at.start..o + at.end);
        let mut segments = Vec::new();
        let mut table = table.get_ref();
        loop {
            let mut entries = table.iter();
            let (Some((key, value)), None) = (entries.next(), entries.next()) else { return Err(bad()) };
            segments.push((key.get_ref().to_string(), shifted(key.span())));
            match value.get_ref() {
                DeValue::Table(inner) => table = inner,
                // The text is only a key if the value is the appended one.
                _ if value.span().start + 1 == document.len() => return Ok(KeyPath { segments }),
                _ => return Err(bad()),
            }
        }
    }

    /// True when one path is a prefix of the other.
    pub fn overlaps(&self, other: &KeyPath) -> bool {
        self.segments.iter().zip(&other.segments).all(|(a, b)| a.0 == b.0)
    }

    /// Its first segments.
    pub fn prefix(&self, count: usize) -> KeyPath {
        KeyPath { segments: self.segments[..count].to_vec() }
    }

    /// True when both lead to the same value.
    pub fn equals(&self, other: &KeyPath) -> bool {
        self.segments.len() == other.segments.len() && self.overlaps(other)
    }

    /// Sets the value at the path. Missing tables are created; entries of arrays must exist.
    pub fn set(&self, root: &mut Node, value: Node) -> Result<(), PathError> {
        let mut node = root;
        let last = self.segments.len() - 1;
        let mut passed: Vec<&str> = Vec::new();
        for (i, (key, span)) in self.segments.iter().enumerate() {
            let fail = |message: String| PathError { span: span.clone(), message };
            let here = passed.join(".");
            node = match &mut node.value {
                Value::Array(items) => {
                    let length = items.len();
                    let index: usize = key
                        .parse()
                        .map_err(|_| fail(format!("`{here}` is an array: `{key}` must be an index from 0")))?;
                    let entries = if length == 1 { "entry" } else { "entries" };
                    items
                        .get_mut(index)
                        .ok_or_else(|| fail(format!("there is no `{here}.{index}`: `{here}` has {length} {entries}")))?
                }
                Value::Table(entries) => {
                    let at = match entries.iter().position(|e| e.key == *key) {
                        Some(at) => at,
                        None => {
                            // The other entries of a new array would be undefined.
                            if let Some(next) = self.segments.get(i + 1).filter(|s| s.0.parse::<usize>().is_ok()) {
                                let array = passed.iter().copied().chain([key.as_str()]).collect::<Vec<_>>().join(".");
                                let index = &next.0;
                                return Err(fail(format!("there is no `{array}.{index}`: the file has no `{array}`")));
                            }
                            let node = Node { span: span.clone(), value: Value::Table(Vec::new()) };
                            entries.push(Entry { key: key.clone(), key_span: span.clone(), node });
                            entries.len() - 1
                        }
                    };
                    &mut entries[at].node
                }
                other => return Err(fail(format!("`{here}` is {other} and has no `{key}`"))),
            };
            passed.push(key);
            if i == last {
                *node = value;
                return Ok(());
            }
        }
        Ok(())
    }

    /// The value the path leads to.
    pub fn get<'a>(&self, root: &'a Node) -> Option<&'a Node> {
        self.segments.iter().try_fold(root, |node, (key, _)| match &node.value {
            Value::Array(items) => items.get(key.parse::<usize>().ok()?),
            _ => node.get(key),
        })
    }

    /// The value the path leads to, in a plain TOML table.
    pub fn look_up<'a>(&self, table: &'a toml::Table) -> Option<&'a toml::Value> {
        let ((first, _), rest) = self.segments.split_first()?;
        rest.iter().try_fold(table.get(first)?, |value, (key, _)| match value {
            toml::Value::Array(items) => items.get(key.parse::<usize>().ok()?),
            other => other.get(key),
        })
    }

    /// The spans of the key and of the value at the path, or of its longest part that exists.
    pub fn locate(&self, root: &Node) -> (Span, Span) {
        let mut found = (root.span.clone(), root.span.clone());
        let mut node = root;
        for (key, _) in &self.segments {
            let next = match &node.value {
                Value::Table(_) => node.entry(key).map(|e| (e.key_span.clone(), &e.node)),
                Value::Array(items) => key.parse().ok().and_then(|i: usize| items.get(i)).map(|n| (n.span.clone(), n)),
                _ => None,
            };
            let Some((key_span, child)) = next else { break };
            found = (key_span, child.span.clone());
            node = child;
        }
        found
    }

    /// A path that the program itself writes, without a span.
    pub fn internal(text: &str) -> KeyPath {
        let nowhere = Sources::default();
        KeyPath::parse(text, &(0..0), &nowhere)
            .unwrap_or_else(|_| KeyPath { segments: text.split('.').map(|s| (s.to_owned(), 0..0)).collect() })
    }
}
