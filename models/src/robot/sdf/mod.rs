//! Reads a model of an SDFormat file to the tree of moving links.
//!
//! The room `sdf` reads the document and resolves its frames. Here joints become the tree: fixed
//! ones are welded, each axis becomes z of an internal frame, and a second joint of a link closes a
//! loop. The file of a robot holds one model, or the name of one follows the path: `FILE#MODEL`.
//! `FILE#MODEL::LINK::SHAPE` has only that collision shape.
//!
//! Called by the loader of robots.

mod inertia;
mod joints;
mod shapes;
mod spanning_tree;
mod tree;

use super::model::Base;
use super::notices::Notices;
use super::robot_error::{FileError, RobotError};
use super::urdf::{InertiaPolicy, Loaded};
use crate::sdf::{self, At, Document, ErrorKind, ErrorText, Model, Pose, SdfError};
use crate::text::source::Source;
use crate::text::suggest::nearest;

/// Reads a model. `name` selects one of several, and may select a shape of it; `base`, if given,
/// decides how the root is held.
pub(super) fn load(
    source: &Source,
    name: Option<&str>,
    base: Option<Base>,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Loaded, RobotError> {
    let (name, shape) = match name.and_then(|name| name.split_once("::")) {
        Some((model, shape)) => (Some(model), Some(shape)),
        None => (name, None),
    };
    let is_other = |model: &str| name.is_some_and(|name| name != model);
    let document = sdf::read_selected(source, &is_other).map_err(convert)?;
    let Document { models, worlds, mut files, remarks } = document;
    let mut models: Vec<Model> = models.into_iter().chain(worlds.into_iter().flat_map(|world| world.models)).collect();
    if let (Some(shape), Some(model)) = (shape, models.iter_mut().find(|m| Some(m.name.as_str()) == name))
        && !keep_shape(model, shape)
    {
        let message = format!("model `{}` has no collision shape `{shape}`", model.name);
        return Err(convert(SdfError::new(model.at.clone(), message).expected("LINK::SHAPE")));
    }
    let model = choose(source, &models, name)?;
    for remark in remarks.into_list() {
        let At { source, span } = &remark.at;
        match remark.is_warning {
            true => notices.warning(source, span.start, remark.message),
            false => notices.info(source, span.start, remark.message),
        }
    }
    // A model that is selected by name belongs to a world, which places it.
    if name.is_none() && model.pose.pose != Pose::IDENTITY {
        let message = format!("the pose of model `{}` is ignored: the scenario sets that of the base", model.name);
        notices.info(&model.pose.at.source, model.pose.at.span.start, message);
    }
    let mut loaded = tree::build(model, base, policy, notices)?;
    files.append(&mut loaded.meshes);
    Ok(Loaded { meshes: files, ..loaded })
}

/// Removes all shapes but the collision shape `LINK::SHAPE`; false without one.
fn keep_shape(model: &mut Model, path: &str) -> bool {
    let mut is_found = false;
    for link in &mut model.links {
        link.visuals.clear();
        let shape = path.strip_prefix(link.name.as_str()).and_then(|rest| rest.strip_prefix("::"));
        let position = link.collisions.iter().position(|collision| Some(collision.name.as_str()) == shape);
        let kept = position.map(|k| link.collisions.swap_remove(k));
        is_found |= kept.is_some();
        link.collisions = kept.into_iter().collect();
    }
    for nested in &mut model.models {
        let inner = path.strip_prefix(nested.name.as_str()).and_then(|rest| rest.strip_prefix("::"));
        is_found |= keep_shape(nested, inner.unwrap_or_default());
    }
    is_found
}

/// The only model, or the one of that name.
fn choose<'a>(source: &Source, models: &'a [Model], name: Option<&str>) -> Result<&'a Model, RobotError> {
    let file = |message: String| FileError::new(source, 0..0, message).element("<sdf>");
    match (models, name) {
        (_, Some(name)) => models.iter().find(|model| model.name == name).ok_or_else(|| {
            let error = file(format!("the file has no model `{name}`"));
            let known = sdf::read(source).map(|all| {
                all.models.into_iter().chain(all.worlds.into_iter().flat_map(|w| w.models)).map(|m| m.name).collect()
            });
            let known: Vec<String> = known.unwrap_or_default();
            match nearest(name, known.iter().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error,
            }
            .invalid()
        }),
        ([only], None) => Ok(only),
        ([], None) => Err(file("the file has no model".into()).expected("one <model>").invalid()),
        ([_, second, ..], None) => {
            let message = format!("the file has {} models", models.len());
            let error = FileError::new(&second.at.source, second.at.span.clone(), message).element("<sdf>");
            Err(error.expected("one <model>").help("`FILE#MODEL` names one of them").invalid())
        }
    }
}

/// An error of a document as one of a robot.
fn convert(error: SdfError) -> RobotError {
    let ErrorText { at, kind, message, element, found, expected, help } = *error.0;
    let fault = FileError::new(&at.source, at.span, message).element(element).found(found).expected(expected);
    let fault = match help {
        Some(help) => fault.help(help),
        None => fault,
    };
    match kind {
        ErrorKind::Syntax => fault.syntax(),
        ErrorKind::Invalid => fault.invalid(),
        ErrorKind::NotAvailable => fault.not_available(),
    }
}
