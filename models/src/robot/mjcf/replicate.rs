//! `<replicate>`: copies of its elements, each in a frame of its own, as MuJoCo expands them.
//!
//! The frame of copy i is turned by i times the angles `euler`. Its origin is at `offset` in the
//! frame of copy i - 1. Names end with `sep` and i, with as many digits as `count` has. Sensors,
//! actuators, constraints and contact pairs that name a copied element are copied too.

use std::collections::HashSet;

use nalgebra::{Isometry3, Vector3};

use super::compiler::Compiler;
use super::document::{Attribute, Document, Element, Id};
use super::orientation::euler;
use super::view::View;
use crate::robot::robot_error::RobotError;

/// Greatest number of copies.
const MAX_COUNT: f64 = 1e6;
const ATTRIBUTES: [&str; 5] = ["childclass", "count", "euler", "offset", "sep"];
/// Attributes that name a joint, body, geom or site, by the tag of the named element.
const REFERENCES: [(&str, &str); 14] = [
    ("joint", "joint"),
    ("joint1", "joint"),
    ("joint2", "joint"),
    ("jointinparent", "joint"),
    ("body", "body"),
    ("body1", "body"),
    ("body2", "body"),
    ("geom1", "geom"),
    ("geom2", "geom"),
    ("site", "site"),
    ("site1", "site"),
    ("site2", "site"),
    ("refsite", "site"),
    ("slidersite", "site"),
];
/// Tags of elements that others name.
const TAGS: [&str; 4] = ["body", "joint", "geom", "site"];
/// Sections whose elements name elements of bodies.
pub(super) const SECTIONS: [&str; 4] = ["sensor", "actuator", "equality", "contact"];

/// Tag and name of each element that is copied.
pub(super) type Names = HashSet<(&'static str, String)>;

/// Expands all `<replicate>` of the file, inner ones first.
///
/// # Errors
/// Attributes that are missing or not valid; too many elements.
pub(super) fn expand(document: &mut Document) -> Result<(), RobotError> {
    let (mut found, mut stack) = (Vec::new(), Vec::new());
    stack.extend(document.section("worldbody"));
    while let Some(id) = stack.pop() {
        if document.tag(id) == "replicate" {
            found.push(id);
        }
        stack.extend(document.children(id));
    }
    if found.is_empty() {
        return Ok(());
    }
    let compiler = Compiler::read(document)?;
    found.iter().rev().try_for_each(|&id| copies(document, id, &compiler))
}

/// Replaces a `<replicate>` by a frame of its copies.
fn copies(document: &mut Document, id: Id, compiler: &Compiler) -> Result<(), RobotError> {
    let view = View::bare(document, id);
    let unknown = document.element(id).attributes.iter().map(|a| a.name.as_str()).find(|a| !ATTRIBUTES.contains(a));
    if let Some(name) = unknown {
        let fault = document.attribute_fault(id, name, format!("<replicate> has no attribute `{name}`"));
        return Err(fault.expected("an attribute of MJCF").suggest(name, ATTRIBUTES).invalid());
    }
    let Some(count) = view.number("count")? else { return Err(view.missing("count")) };
    if !(count.fract() == 0.0 && (0.0..=MAX_COUNT).contains(&count)) {
        return Err(view.fault("count", format!("a whole number from 0 to {MAX_COUNT}")).invalid());
    }
    let count = count as usize;
    let offset = Vector3::from(view.array::<3>("offset")?.unwrap_or_default());
    let angles = view.array::<3>("euler")?.unwrap_or_default();
    let separator = view.text("sep").unwrap_or_default().to_owned();
    let digits = count.to_string().len();
    let suffixes: Vec<String> = (0..count).map(|i| format!("{separator}{i:0digits$}")).collect();

    let children = document.children(id).to_vec();
    let names = names(document, &children);
    let (mut frames, mut position) = (Vec::new(), Vector3::zeros());
    for (i, suffix) in suffixes.iter().enumerate() {
        let rotation = euler(angles.map(|angle| i as f64 * angle), compiler);
        let pose = Isometry3::from_parts(position.into(), rotation);
        let frame = document.push(frame(document.element(id), &pose))?;
        for &child in &children {
            let copy = copy(document, child, suffix)?;
            document.element_mut(frame).children.push(copy);
        }
        frames.push(frame);
        position += rotation * offset;
    }
    let element = document.element_mut(id);
    "frame".clone_into(&mut element.tag);
    element.attributes.retain(|attribute| attribute.name == "childclass");
    element.children = frames;
    references(document, &names, &suffixes)
}

/// Names of elements below some, by tag.
pub(super) fn names(document: &Document, children: &[Id]) -> Names {
    let (mut names, mut stack) = (Names::new(), children.to_vec());
    while let Some(id) = stack.pop() {
        stack.extend(document.children(id));
        let tag = if document.tag(id) == "freejoint" { "joint" } else { document.tag(id) };
        if let (Some(tag), Some(name)) = (TAGS.into_iter().find(|known| *known == tag), document.text(id, "name")) {
            names.insert((tag, name.to_owned()));
        }
    }
    names
}

/// A frame at the position of an element in the file.
fn frame(of: &Element, pose: &Isometry3<f64>) -> Element {
    let text = |list: &[f64]| list.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
    let (p, q) = (pose.translation.vector, pose.rotation);
    let attributes = [("pos", text(p.as_slice())), ("quat", text(&[q.w, q.i, q.j, q.k]))];
    let attribute = |(name, value): (&str, String)| Attribute { name: name.into(), value, span: of.span.clone() };
    let attributes = attributes.into_iter().map(attribute).collect();
    Element { tag: "frame".into(), attributes, children: Vec::new(), ..of.clone() }
}

/// Copies an element of a body and all below it. Recursion is as deep as the file nests.
fn copy(document: &mut Document, id: Id, suffix: &str) -> Result<Id, RobotError> {
    let mut new = document.element(id).clone();
    let children = std::mem::take(&mut new.children);
    new.attributes.iter_mut().filter(|a| a.name == "name" && !a.value.is_empty()).for_each(|a| a.value += suffix);
    let new = document.push(new)?;
    for child in children {
        let child = copy(document, child, suffix)?;
        document.element_mut(new).children.push(child);
    }
    Ok(new)
}

/// True for an attribute that names a joint, body, geom or site.
pub(super) fn is_reference(attribute: &str) -> bool {
    matches!(attribute, "objname" | "refname") || REFERENCES.iter().any(|(known, _)| *known == attribute)
}

/// Replaces each element that names copied ones by its copies.
fn references(document: &mut Document, names: &Names, suffixes: &[String]) -> Result<(), RobotError> {
    for section in SECTIONS.into_iter().flat_map(|name| document.section(name).collect::<Vec<_>>()).collect::<Vec<_>>()
    {
        let mut children = Vec::new();
        for child in document.element(section).children.clone() {
            let named = references_of(document.element(child), names);
            if named.is_empty() {
                children.push(child);
                continue;
            }
            for suffix in suffixes {
                let mut new = document.element(child).clone();
                for (k, attribute) in new.attributes.iter_mut().enumerate() {
                    if named.contains(&k) || attribute.name == "name" && !attribute.value.is_empty() {
                        attribute.value += suffix;
                    }
                }
                children.push(document.push(new)?);
            }
        }
        document.element_mut(section).children = children;
    }
    Ok(())
}

/// The attributes of an element that name copied ones.
pub(super) fn references_of(element: &Element, names: &Names) -> Vec<usize> {
    let text = |name: &str| element.attributes.iter().find(|a| a.name == name).map(|a| a.value.as_str());
    let is_named = |attribute: &Attribute| {
        let tag = match attribute.name.as_str() {
            "objname" => text("objtype"),
            "refname" => text("reftype"),
            name => REFERENCES.iter().find(|(known, _)| *known == name).map(|(_, tag)| *tag),
        };
        // `xbody` is the frame of a body, `body` that of its inertia.
        let tag = if tag == Some("xbody") { Some("body") } else { tag };
        let known = tag.and_then(|tag| TAGS.into_iter().find(|known| *known == tag));
        known.is_some_and(|tag| names.contains(&(tag, attribute.value.clone())))
    };
    element.attributes.iter().enumerate().filter(|(_, a)| is_named(a)).map(|(k, _)| k).collect()
}
