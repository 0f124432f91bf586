//! Reads files, worlds, models and links.

use std::collections::HashMap;

use super::document::{Document, Frame, Link, Model, SdfError, Sensor, World};
use super::geometry::{inertial, pose, shape};
use super::includes::include;
use super::read_joint::joint;
use super::remarks::Remarks;
use super::xml::{Element, parse};
use crate::text::source::Source;

/// A version of the format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct Version(pub u32, pub u32);

/// Versions that are read.
const VERSIONS: [Version; 2] = [Version(1, 3), Version(1, 12)];

/// Greatest depth of nested and included models.
pub(super) const MAX_DEPTH: usize = 16;

/// Greatest number of models of a file with those that it includes.
const MAX_MODELS: usize = 10_000;

/// Data of the reading of one document.
pub(super) struct Reading<'r> {
    pub document: Document,
    /// True for names of models of a world that are left out.
    pub skip: &'r dyn Fn(&str) -> bool,
    pub models: usize,
}

/// Reads a text with the files that it includes.
///
/// # Errors
/// The first one found.
pub fn read(source: &Source) -> Result<Document, SdfError> {
    read_selected(source, &|_| false)
}

/// As [`read`], without those models of worlds and of `<sdf>` for whose names `skip` is true. The
/// files that they would include are not read.
///
/// # Errors
/// See [`read`].
pub fn read_selected(source: &Source, skip: &dyn Fn(&str) -> bool) -> Result<Document, SdfError> {
    let mut reading = Reading { document: Document::default(), skip, models: 0 };
    read_file(source, &mut reading, 0)?;
    Ok(reading.document)
}

/// Reads a file into the document.
pub(super) fn read_file(source: &Source, reading: &mut Reading, depth: usize) -> Result<(), SdfError> {
    let xml = parse(source)?;
    let root = Element { node: xml.root_element(), source };
    if root.tag() != "sdf" {
        let error = root.error("this is not SDFormat").found(format!("<{}>", root.tag()));
        return Err(error.expected("<sdf version=\"...\">"));
    }
    let version = version(&root)?;
    root.check_children(&mut reading.document.remarks);
    for element in root.all("model") {
        if let Some(model) = selected_model(&element, version, reading, depth)? {
            reading.document.models.push(model);
        }
    }
    for element in root.all("world") {
        let world = world(&element, version, reading, depth)?;
        reading.document.worlds.push(world);
    }
    Ok(())
}

fn version(root: &Element) -> Result<Version, SdfError> {
    let text = root.attribute("version").unwrap_or("");
    let mut parts = text.splitn(2, '.').map(|part| part.trim().parse::<u32>());
    let [first, last] = VERSIONS;
    match (parts.next(), parts.next()) {
        (Some(Ok(major)), Some(Ok(minor))) if (first..=last).contains(&Version(major, minor)) => {
            Ok(Version(major, minor))
        }
        _ => {
            let error = SdfError::new(root.at_attribute("version"), "the version of the format is not known");
            let error = error.element("<sdf>").found(format!("`{text}`"));
            Err(error.expected(format!("{}.{} to {}.{}", first.0, first.1, last.0, last.1)))
        }
    }
}

/// A model, unless it is skipped by name.
fn selected_model(
    element: &Element,
    version: Version,
    reading: &mut Reading,
    depth: usize,
) -> Result<Option<Model>, SdfError> {
    match depth == 0 && (reading.skip)(&element.name()?) {
        true => Ok(None),
        false => model(element, version, reading, depth).map(Some),
    }
}

fn world(element: &Element, version: Version, reading: &mut Reading, depth: usize) -> Result<World, SdfError> {
    element.check_children(&mut reading.document.remarks);
    let gravity = match element.child("gravity")? {
        Some(gravity) => Some((gravity.numbers()?, gravity.at_value())),
        None => None,
    };
    let mut models = Vec::new();
    for element in element.all("model") {
        models.extend(selected_model(&element, version, reading, depth)?);
    }
    for element in element.all("include") {
        models.extend(include(&element, reading, depth, true)?);
    }
    let frames = frames(element, &mut reading.document.remarks)?;
    unique("model", models.iter().map(|m| (m.name.as_str(), &m.at)))?;
    Ok(World { at: element.at(), gravity, models, frames })
}

/// A `<model>`.
pub(super) fn model(
    element: &Element,
    version: Version,
    reading: &mut Reading,
    depth: usize,
) -> Result<Model, SdfError> {
    if depth > MAX_DEPTH {
        return Err(element.error("models are nested too deeply").expected(format!("at most {MAX_DEPTH} levels")));
    }
    reading.models += 1;
    if reading.models > MAX_MODELS {
        return Err(element.error("there are too many models").expected(format!("at most {MAX_MODELS}")));
    }
    let remarks = &mut reading.document.remarks;
    element.check_children(remarks);
    let name = element.name()?;
    let pose = pose(element, remarks)?;
    let frames = frames(element, remarks)?;
    let links = element.all("link").map(|e| link(&e, remarks)).collect::<Result<Vec<_>, _>>()?;
    let joints = element.all("joint").map(|e| joint(&e, version, remarks)).collect::<Result<Vec<_>, _>>()?;
    let is_static = element.boolean("static")?;
    let mut models = Vec::new();
    for nested in element.all("model") {
        models.push(model(&nested, version, reading, depth + 1)?);
    }
    for nested in element.all("include") {
        models.extend(include(&nested, reading, depth, false)?);
    }
    let named = links.iter().map(|l| (l.name.as_str(), &l.at));
    let named = named.chain(joints.iter().map(|j| (j.name.as_str(), &j.at)));
    let named = named.chain(frames.iter().map(|f| (f.name.as_str(), &f.at)));
    unique("link, joint, frame or model", named.chain(models.iter().map(|m| (m.name.as_str(), &m.at))))?;
    Ok(Model {
        name,
        at: element.at(),
        is_static,
        pose,
        placement_frame: element.named("placement_frame"),
        canonical_link: element.named("canonical_link"),
        links,
        joints,
        frames,
        models,
    })
}

/// Names must differ within a model.
fn unique<'a>(kind: &str, named: impl Iterator<Item = (&'a str, &'a super::document::At)>) -> Result<(), SdfError> {
    let mut lines: HashMap<&str, usize> = HashMap::new();
    for (name, at) in named {
        if let Some(first) = lines.insert(name, at.source.line(at.span.start)) {
            let error = SdfError::new(at.clone(), format!("there are two of the name `{name}`")).element(kind);
            return Err(error.expected("a unique name").help(format!("the other is on line {first}")));
        }
    }
    Ok(())
}

fn frames(element: &Element, remarks: &mut Remarks) -> Result<Vec<Frame>, SdfError> {
    let mut frames = Vec::new();
    for frame in element.all("frame") {
        frame.check_children(remarks);
        let (name, attached_to) = (frame.name()?, frame.named("attached_to"));
        frames.push(Frame { name, attached_to, pose: pose(&frame, remarks)?, at: frame.at() });
    }
    Ok(frames)
}

fn link(element: &Element, remarks: &mut Remarks) -> Result<Link, SdfError> {
    element.check_children(remarks);
    let name = element.name()?;
    if name == "world" {
        return Err(element.error("a link cannot be called `world`").expected("another name"));
    }
    for (tag, plain, message) in [
        ("gravity", true, "falls as all others, although its <gravity> is false"),
        ("kinematic", false, "moves by forces, although it is <kinematic>"),
    ] {
        if let Some(flag) = element.child(tag)?
            && flag.truth()? != plain
        {
            remarks.warning(flag.at(), format!("link `{name}` {message}"));
        }
    }
    let shapes = |tag, remarks: &mut Remarks| -> Result<Vec<_>, SdfError> {
        element.all(tag).map(|e| shape(&e, remarks)).collect()
    };
    Ok(Link {
        name,
        at: element.at(),
        pose: pose(element, remarks)?,
        inertial: inertial(element, remarks)?,
        visuals: shapes("visual", remarks)?,
        collisions: shapes("collision", remarks)?,
        sensors: sensors(element, remarks)?,
    })
}

/// Sensors of a link or joint.
pub(super) fn sensors(element: &Element, remarks: &mut Remarks) -> Result<Vec<Sensor>, SdfError> {
    let mut sensors = Vec::new();
    for sensor in element.all("sensor") {
        let kind = sensor.attribute("type").unwrap_or_default();
        if !["imu", "force_torque"].contains(&kind) {
            remarks.ignore(sensor.at(), format!("<sensor type=\"{kind}\">"));
            continue;
        }
        let name = sensor.name()?;
        sensors.push(Sensor { name, kind: kind.to_owned(), at: sensor.at(), pose: pose(&sensor, remarks)? });
    }
    Ok(sensors)
}
