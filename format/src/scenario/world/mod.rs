//! Adds the bodies of a world file to a scenario's tree: fixed ones to `terrain`, others to
//! `object`, its plane to `floor`, and its gravity.
//!
//! The nodes have spans in the world file, so that errors and remarks are shown there. The
//! scenario of a run has the added entries in place of `[world]`, and so have records and logs.

mod entries;
mod height_map;
mod nodes;
mod read_world;
mod solid;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;

use super::decode::NodeDeserializer;
use super::file::resolve;
use crate::input;
use crate::robot::is_mjcf_name;
use crate::scenario::findings::Findings;
use crate::scenario::format::world::WorldSpec;
use crate::sdf::is_sdf_name;
use crate::text::source::{Source, Sources, Span};
use crate::text::toml_tree::{Entry, Node, Value};

pub(super) use read_world::WorldNodes;

/// Worlds read so far, each once.
#[derive(Default)]
pub(super) struct Worlds {
    read: HashMap<(String, Vec<String>), Arc<WorldNodes>>,
}

impl Worlds {
    /// Replaces the `world` of a tree by the entries of its file. Returns them; `None` without a
    /// world or after an error, which goes to `findings`.
    pub fn expand(
        &mut self,
        root: &mut Node,
        scenario: &Path,
        sources: &mut Sources,
        findings: &mut Findings,
    ) -> Option<Arc<WorldNodes>> {
        let node = root.get("world")?.clone();
        let spec = match WorldSpec::deserialize(NodeDeserializer(&node)) {
            Ok(spec) => spec,
            Err(error) => {
                error.at(&node.span).report("world", findings);
                return None;
            }
        };
        let span = node.get("file").map_or(node.span.clone(), |file| file.span.clone());
        let ignore = node.get("ignore").map_or(span.clone(), |ignore| ignore.span.clone());
        let key = (spec.file.clone(), spec.ignore.clone());
        let world = match self.read.get(&key) {
            Some(known) => known.clone(),
            None => {
                let path = resolve(scenario, Path::new(&spec.file));
                if !is_sdf_name(&path) && !is_mjcf_name(&path) {
                    let message =
                        format!("`world.file` must be a .sdf, .world, .xml or .mjcf file, not {:?}", spec.file);
                    findings.error(span, message, None);
                    return None;
                }
                let text = match input::read_text(&path, input::MOST_TEXT) {
                    Ok(text) => text,
                    Err(error) => {
                        findings.error(span, format!("cannot read {}: {error}", path.display()), None);
                        return None;
                    }
                };
                let base = scenario.parent().unwrap_or(Path::new(""));
                let world = read_world::read(&Source::new(path, text), &spec, base, sources);
                self.read.entry(key).or_insert(Arc::new(world)).clone()
            }
        };
        world.report((&span, &ignore), findings);
        world.insert(root);
        Some(world)
    }
}

/// Appends nodes to the array `key` of a tree, which is created if absent.
fn append(root: &mut Node, key: &str, nodes: &[Node], span: &Span) {
    if nodes.is_empty() {
        return;
    }
    if root.get(key).is_none() {
        set(root, key, Node { span: span.clone(), value: Value::Array(Vec::new()) });
    }
    // Another value in its place is an error of the scenario.
    if let Some(Node { value: Value::Array(items), .. }) = root.get_mut(key) {
        items.extend_from_slice(nodes);
    }
}

fn set(root: &mut Node, key: &str, node: Node) {
    if let Value::Table(entries) = &mut root.value {
        entries.push(Entry { key: key.to_owned(), key_span: node.span.clone(), node });
    }
}
