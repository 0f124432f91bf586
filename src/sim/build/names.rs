//! Where names of a scenario meet what the robot has.

use crate::robot::{Base, JointId, LinkId, Model, SoleId};
use crate::scenario::{Diagnostic, Run, segment, suggest};
use nalgebra::Isometry3;

/// Joint numbers of named values; unknown names are errors at their keys under `path`.
pub(super) fn joints<'a>(
    model: &Model,
    run: &Run,
    path: &str,
    named: impl Iterator<Item = (&'a String, &'a f64)>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<(JointId, f64)> {
    let mut found = Vec::new();
    for (name, &value) in named {
        match model.joint(name) {
            Some(id) => found.push((id, value)),
            None => {
                let help = suggest(name, model.joints.iter().map(|j| j.name.as_str()));
                let message = format!("the robot `{}` has no joint `{name}`", model.name);
                errors.push(run.error_at_key(&format!("{path}.{}", segment(name)), message, Some(help)));
            }
        }
    }
    found
}

/// The link that stands at `path`, with the pose of its URDF frame in the carrying link's internal frame; an unknown one
/// is an error there.
pub(super) fn link(
    model: &Model,
    run: &Run,
    path: &str,
    name: &str,
    errors: &mut Vec<Diagnostic>,
) -> Option<(LinkId, Isometry3<f64>)> {
    let found = model.link(name);
    if found.is_none() {
        let names = model
            .links
            .iter()
            .flat_map(|l| std::iter::once(l.name.as_str()).chain(l.merged.iter().map(|m| m.name.as_str())));
        let help = suggest(name, names.collect::<Vec<_>>());
        let message = format!("the robot `{}` has no link `{name}`", model.name);
        errors.push(run.error_at(path, message, Some(help)));
    }
    found
}

/// As [`link`], of one that a force can move: not the root of a robot that is fixed, nor what is welded to it.
pub(super) fn moving_link(
    model: &Model,
    run: &Run,
    path: &str,
    name: &str,
    errors: &mut Vec<Diagnostic>,
) -> Option<(LinkId, Isometry3<f64>)> {
    let found = link(model, run, path, name, errors)?;
    if model.base == Base::Fixed && found.0 == LinkId(0) {
        let message = format!("the link `{name}` of the robot `{}` is fixed: nothing here could move it", model.name);
        let names = crate::script::links(model).filter(|(_, id, _)| *id != LinkId(0)).map(|(name, ..)| name);
        errors.push(run.error_at(
            path,
            message,
            Some(format!("links that move: {}", names.collect::<Vec<_>>().join(", "))),
        ));
        return None;
    }
    Some(found)
}

/// Numbers of named soles; unknown and repeated names are errors at their places under `path`.
pub(super) fn soles(
    model: &Model,
    run: &Run,
    path: &str,
    named: &[String],
    errors: &mut Vec<Diagnostic>,
) -> Vec<SoleId> {
    let mut found = Vec::new();
    for (i, name) in named.iter().enumerate() {
        match model.soles.iter().position(|s| s.name == *name).map(SoleId) {
            Some(id) if found.contains(&id) => {
                errors.push(run.error_at(&format!("{path}.{i}"), format!("the sole `{name}` is named twice"), None));
            }
            Some(id) => found.push(id),
            None => {
                let help = suggest(name, model.soles.iter().map(|s| s.name.as_str()));
                let message = format!("the robot `{}` has no sole `{name}`", model.name);
                errors.push(run.error_at(&format!("{path}.{i}"), message, Some(help)));
            }
        }
    }
    found
}
