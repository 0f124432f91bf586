//! Reads a world file to nodes of a scenario's tree.

use std::cell::RefCell;
use std::path::Path;

use super::entries::Entries;
use super::{append, nodes, set};
use crate::robot::read_mjcf_world;
use crate::scenario::findings::Findings;
use crate::scenario::format::world::WorldSpec;
use crate::sdf::{self, At, Document, SdfError, World, resolve, world_frames};
use crate::text::diagnostic::Severity;
use crate::text::pattern::matches;
use crate::text::source::{Source, Sources, Span};
use crate::text::toml_tree::Node;
use crate::text::xml_syntax::root_tag;

/// The entries of a world file, with what its reader found.
#[derive(Debug, Default)]
pub struct WorldNodes {
    terrain: Vec<Node>,
    object: Vec<Node>,
    /// The floor, unless the scenario has its own: a plane, or none.
    floor: Option<Node>,
    /// Note for a scenario that has its own floor, at the plane.
    unused_floor: Option<(Span, String)>,
    gravity: Option<Node>,
    found: Vec<(Severity, Span, String, Option<String>)>,
    /// Entries of `ignore` that match nothing.
    unmatched: Vec<String>,
}

impl WorldNodes {
    /// Reports errors, warnings and notes. Those of an earlier cell are not repeated.
    pub(super) fn report(&self, (span, ignore): (&Span, &Span), findings: &mut Findings) {
        for pattern in &self.unmatched {
            let message = format!("nothing in the world matches {pattern:?} of `world.ignore`");
            findings.warning(ignore.clone(), message, None);
        }
        if self.terrain.is_empty() && self.object.is_empty() && self.floor.is_none() && self.found.is_empty() {
            findings.warning(span.clone(), "the world has no bodies", None);
        }
        for (severity, span, message, help) in &self.found {
            match severity {
                Severity::Error => findings.error(span.clone(), message, help.clone()),
                Severity::Warning => findings.warning(span.clone(), message, help.clone()),
                Severity::Note => findings.note(span.clone(), message, help.clone()),
            }
        }
    }

    /// Replaces `world` in a tree.
    pub fn insert(&self, root: &mut Node) {
        let Some(world) = root.remove("world") else { return };
        let span = world.key_span;
        append(root, "terrain", &self.terrain, &span);
        append(root, "object", &self.object, &span);
        for (key, node) in [("floor", &self.floor), ("gravity", &self.gravity)] {
            if let (Some(node), None) = (node, root.get(key)) {
                set(root, key, node.clone());
            }
        }
    }

    /// The note for a scenario that has its own floor.
    pub fn note_unused_floor(&self, findings: &mut Findings) {
        if let Some((span, message)) = &self.unused_floor {
            findings.note(span.clone(), message, None);
        }
    }
}

/// Positions in the common space of a scenario's texts.
pub(super) struct Spans<'s> {
    sources: &'s mut Sources,
    added: Vec<(Source, usize)>,
}

impl Spans<'_> {
    /// The span of an element; its file is added to the sources.
    pub fn of(&mut self, at: &At) -> Span {
        let start = match self.added.iter().find(|(known, _)| known.path() == at.source.path()) {
            Some((_, start)) => *start,
            None => {
                let start = self.sources.add(at.source.path(), at.source.text());
                self.added.push((at.source.clone(), start));
                start
            }
        };
        start + at.span.start..start + at.span.end
    }
}

/// Reads a world; paths in the entries are relative to `base`, the scenario's folder.
pub(super) fn read(source: &Source, spec: &WorldSpec, base: &Path, sources: &mut Sources) -> WorldNodes {
    let mut spans = Spans { sources, added: Vec::new() };
    let mut nodes = WorldNodes::default();
    let matched = RefCell::new(vec![false; spec.ignore.len()]);
    let skip = |name: &str| {
        let mut matched = matched.borrow_mut();
        let each = spec.ignore.iter().zip(&mut *matched).map(|(pattern, matched)| {
            let is_skipped = matches(pattern, name);
            *matched |= is_skipped;
            is_skipped
        });
        each.fold(false, |any, is_skipped| any | is_skipped)
    };
    let is_mjcf = matches!(root_tag(source.text()), Some((_, "mujoco" | "mujocoinclude")));
    let read = if is_mjcf { read_mjcf_world(source, &skip) } else { sdf::read_selected(source, &skip) };
    let read = read.and_then(|document| only_world(source, document));
    let done = read.and_then(|(world, document)| {
        for remark in document.remarks.into_list() {
            let severity = if remark.is_warning { Severity::Warning } else { Severity::Note };
            nodes.found.push((severity, spans.of(&remark.at), remark.message, None));
        }
        add(&world, spec, base, &mut spans, &mut nodes)
    });
    if done.is_ok() {
        let each = spec.ignore.iter().zip(matched.into_inner());
        nodes.unmatched = each.filter(|(_, matched)| !matched).map(|(pattern, _)| pattern.clone()).collect();
    }
    if let Err(error) = done {
        let help = error.0.help.clone();
        nodes.found.push((Severity::Error, spans.of(&error.0.at), error.sentence(), help));
    }
    nodes
}

/// The only world of a file; one without a world counts as a world of its models.
fn only_world(source: &Source, mut document: Document) -> Result<(World, Document), SdfError> {
    if let [_, second, ..] = &document.worlds[..] {
        let error = SdfError::new(second.at.clone(), "the file has several worlds");
        return Err(error.expected("one <world>"));
    }
    if let Some(world) = document.worlds.pop() {
        return Ok((world, document));
    }
    let at = At { source: source.clone(), span: 0..0 };
    let world = World { at, gravity: None, models: std::mem::take(&mut document.models), frames: Vec::new() };
    Ok((world, document))
}

fn add(
    world: &World,
    spec: &WorldSpec,
    base: &Path,
    spans: &mut Spans,
    found: &mut WorldNodes,
) -> Result<(), SdfError> {
    let poses = world_frames(&world.models, &world.frames)?;
    let mut entries = Entries::new(&spec.file, base, spans);
    for (model, pose) in world.models.iter().zip(&poses) {
        entries.add(model, &resolve(model)?, pose);
    }
    let Entries { terrain, object, plane, remarks, .. } = entries;
    (found.terrain, found.object) = (terrain, object);
    found.found.extend(remarks);
    let span = spans.of(&world.at);
    found.floor = Some(match plane {
        Some((height, mu, at)) => {
            let message = "the plane is ignored: the scenario has its own `[floor]`".to_owned();
            found.unused_floor = Some((at.clone(), message));
            let mut keys = vec![("height", nodes::number(height, &at))];
            keys.extend(mu.map(|mu| ("friction", nodes::number(mu, &at))));
            nodes::table(keys, &at)
        }
        None => nodes::table(vec![("plane", nodes::truth(false, &span))], &span),
    });
    found.gravity = world.gravity.as_ref().map(|(g, at)| nodes::numbers(g, &spans.of(at)));
    Ok(())
}
