//! `<attach>`: a body of another file with all that it carries, under names with a prefix.
//!
//! The other file's default classes, meshes and materials come along, and its sensors, actuators,
//! constraints and contact pairs that name nothing but the attached elements. Its elements without
//! a class have its own class `main`.

use std::path::{Component, Path, PathBuf};

use super::compiler::Compiler;
use super::document::{ATTACHED_DEFAULT, Attribute, Document, Element, Id, ROOT, normalized};
use super::replicate::{self, Names, SECTIONS, references_of};
use super::view::View;
use crate::robot::robot_error::{RobotError, read_source};

const ATTRIBUTES: [&str; 3] = ["body", "model", "prefix"];
/// Attributes that name elements of the same file, besides those of [`replicate`].
const NAMES: [&str; 6] = ["name", "class", "childclass", "mesh", "material", "hfield"];

/// Expands the elements that create bodies: attached models, then copies.
///
/// # Errors
/// Attributes that are missing or not valid; a model that cannot be read, attaches itself or has
/// other settings; too many elements.
pub(super) fn expand(document: &mut Document) -> Result<(), RobotError> {
    let mut chain = vec![normalized(document.sources[0].path())];
    expand_in(document, &mut chain)
}

fn expand_in(document: &mut Document, chain: &mut Vec<PathBuf>) -> Result<(), RobotError> {
    let (mut found, mut stack) = (Vec::new(), Vec::new());
    stack.extend(document.section("worldbody"));
    while let Some(id) = stack.pop() {
        if document.tag(id) == "attach" {
            found.push(id);
        }
        stack.extend(document.children(id).iter().rev());
    }
    found.into_iter().try_for_each(|id| attach(document, id, chain))?;
    replicate::expand(document)
}

fn attach(document: &mut Document, id: Id, chain: &mut Vec<PathBuf>) -> Result<(), RobotError> {
    let view = View::bare(document, id);
    let unknown = document.element(id).attributes.iter().map(|a| a.name.as_str()).find(|a| !ATTRIBUTES.contains(a));
    if let Some(name) = unknown {
        let fault = document.attribute_fault(id, name, format!("<attach> has no attribute `{name}`"));
        return Err(fault.expected("an attribute of MJCF").suggest(name, ATTRIBUTES).invalid());
    }
    let prefix = view.required("prefix")?.to_owned();
    let file = model_file(document, &view)?;
    let path = document.sources[0].path().parent().unwrap_or(Path::new("")).join(&file);
    let key = normalized(&path);
    if chain.contains(&key) {
        let fault = view.fault("model", "models that do not attach each other in a ring");
        return Err(fault.invalid());
    }
    let source =
        read_source(&path).map_err(|error| view.fault("model", "an MJCF file").found(error.to_string()).invalid())?;
    let mut child = Document::read(&source)?;
    chain.push(key);
    expand_in(&mut child, chain)?;
    chain.pop();
    let (own, settings) = (Compiler::read(document)?, Compiler::read(&child)?);
    if let Some(name) = own.difference(&settings) {
        let message = format!("the attached model has another `{name}` in <compiler>");
        let fault = document.attribute_fault(id, "model", message).expected("the settings of this file");
        return Err(fault.not_available());
    }
    // Files of assets are named from this file's folder of meshes.
    let up = own.mesh_folder.components().filter(|part| matches!(part, Component::Normal(_)));
    let up: PathBuf = up.map(|_| Component::ParentDir).collect();
    let folder = up.join(file.parent().unwrap_or(Path::new(""))).join(&settings.mesh_folder);
    for element in child.elements_mut() {
        add_prefix(element, &prefix, &folder);
    }
    let body = view.text("body").map(|name| format!("{prefix}{name}"));
    let children = match &body {
        None => child.section("worldbody").flat_map(|section| child.children(section).to_vec()).collect(),
        Some(body) => match find_body(&child, body) {
            Some(found) => vec![found],
            None => return Err(view.fault("body", "the name of a body of the model").invalid()),
        },
    };
    let names = replicate::names(&child, &children);
    let sections = sections(&mut child, &names, &prefix)?;
    let offset = document.absorb(child)?;
    document.element_mut(ROOT).children.extend(sections.into_iter().map(|id| offset + id));
    let element = document.element_mut(id);
    let span = element.span.clone();
    "frame".clone_into(&mut element.tag);
    element.attributes = vec![Attribute { name: "childclass".into(), value: format!("{prefix}main"), span }];
    element.children = children.into_iter().map(|id| offset + id).collect();
    Ok(())
}

/// The file of the model that an `<attach>` names, relative to the main file.
fn model_file(document: &Document, view: &View) -> Result<PathBuf, RobotError> {
    let model = view.required("model")?;
    let models = document.assets("model");
    let stem = |file| Path::new(file).file_stem().and_then(|stem| stem.to_str());
    let name = |id: Id| document.text(id, "name").or_else(|| document.text(id, "file").and_then(stem));
    let Some(&asset) = models.iter().find(|&&id| name(id) == Some(model)) else {
        let fault = view.fault("model", "the name of a <model> in <asset>");
        return Err(fault.suggest(model, models.iter().filter_map(|&id| name(id))).invalid());
    };
    View::bare(document, asset).required("file").map(PathBuf::from)
}

fn find_body(document: &Document, name: &str) -> Option<Id> {
    let mut stack: Vec<Id> = document.section("worldbody").collect();
    while let Some(id) = stack.pop() {
        if document.tag(id) == "body" && document.text(id, "name") == Some(name) {
            return Some(id);
        }
        stack.extend(document.children(id));
    }
    None
}

/// Gives an element's own name and those that it refers to the prefix, and its file the path of a folder.
fn add_prefix(element: &mut Element, prefix: &str, folder: &Path) {
    let is_asset = matches!(element.tag.as_str(), "mesh" | "hfield");
    let file = element.attributes.iter_mut().find(|a| a.name == "file" && is_asset);
    let stem = file.map(|file| {
        let stem = Path::new(&file.value).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
        file.value = folder.join(&file.value).display().to_string();
        stem
    });
    let has_name = element.attributes.iter().any(|a| a.name == "name" && !a.value.is_empty());
    if let (Some(value), false) = (stem, has_name) {
        element.attributes.push(Attribute { name: "name".into(), value, span: element.span.clone() });
    }
    for attribute in &mut element.attributes {
        let is_name = NAMES.contains(&attribute.name.as_str()) || replicate::is_reference(&attribute.name);
        if is_name && !attribute.value.is_empty() && attribute.value != "world" {
            attribute.value.insert_str(0, prefix);
        }
    }
}

/// The sections of an attached file that come along, with their elements.
fn sections(child: &mut Document, names: &Names, prefix: &str) -> Result<Vec<Id>, RobotError> {
    let class = |element: &Element| {
        let (name, value) = ("class".into(), format!("{prefix}main"));
        Attribute { name, value, span: element.span.clone() }
    };
    let all = child.children(ROOT).to_vec();
    let mut kept = Vec::new();
    for &section in &all {
        let tag = child.tag(section).to_owned();
        let children = child.children(section).to_vec();
        if tag == "default" {
            let element = child.element_mut(section);
            ATTACHED_DEFAULT.clone_into(&mut element.tag);
            element.attributes = vec![class(element)];
        } else if SECTIONS.contains(&tag.as_str()) {
            let is_own = |&id: &Id| {
                let own = references_of(child.element(id), names).len();
                own > 0
                    && own == child.element(id).attributes.iter().filter(|a| replicate::is_reference(&a.name)).count()
            };
            child.element_mut(section).children = children.iter().copied().filter(is_own).collect();
        } else if tag != "asset" && tag != ATTACHED_DEFAULT {
            continue;
        }
        for id in child.children(section).to_vec() {
            let element = child.element_mut(id);
            let has_class = element.attributes.iter().any(|a| a.name == "class");
            let is_of_class = matches!(tag.as_str(), "actuator" | "equality")
                || tag == "asset" && matches!(element.tag.as_str(), "mesh" | "material");
            if is_of_class && !has_class {
                element.attributes.push(class(element));
            }
        }
        kept.push(section);
    }
    // A class without elements, if the file has no defaults.
    let mut root = child.element(ROOT).clone();
    (root.tag, root.children) = (ATTACHED_DEFAULT.into(), Vec::new());
    root.attributes = vec![class(&root)];
    kept.push(child.push(root)?);
    Ok(kept)
}
