//! Where names of a scenario meet what the robot has.

use crate::robot::{JointId, LinkId, Model, SoleId};
use crate::scenario::{Diagnostic, ForceSpec, Run, suggest};
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
                errors.push(run.error_at_key(&format!("{path}.{name}"), message, Some(help)));
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

/// A frame that a force acts in.
pub(super) struct Held {
    /// Name of its link or end effector.
    pub name: String,
    /// The carrying link.
    pub link: LinkId,
    /// Its pose in the carrying link's internal frame.
    pub pose: Isometry3<f64>,
}

/// The frame of the link or end effector that the force entry `i` names; an unknown one is an error at its place.
pub(super) fn held(model: &Model, run: &Run, i: usize, spec: &ForceSpec, errors: &mut Vec<Diagnostic>) -> Option<Held> {
    let grip = spec.grip()?;
    if let Some(name) = grip.link {
        let (link, pose) = link(model, run, &format!("force.{i}.link"), name, errors)?;
        return Some(Held { name: name.to_owned(), link, pose });
    }
    let name = grip.end_effector?;
    let found = model.end_effectors.iter().find(|e| e.name == name);
    if found.is_none() {
        let help = match model.end_effectors.is_empty() {
            true => "its robot file gives none: see `[[end_effector]]` there".to_owned(),
            false => suggest(name, model.end_effectors.iter().map(|e| e.name.as_str())),
        };
        let message = format!("the robot `{}` has no end effector `{name}`", model.name);
        errors.push(run.error_at(&format!("force.{i}.end_effector"), message, Some(help)));
    }
    found.map(|e| Held { name: name.to_owned(), link: e.link, pose: e.pose })
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
