//! Where names of a scenario meet what the robot has.

use crate::robot::{DriveMode, JointId, JointKind, LinkId, Model, SoleId};
use crate::scenario::{BalanceControl, Diagnostic, JointLimits, Run, TaskSpec, suggest};
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

/// Refuses to ask a joint for a position outside its range, at `key`: `what` reaches from `low` to `high`.
pub(super) fn in_range(
    run: &Run,
    model: &Model,
    key: &str,
    JointId(j): JointId,
    (what, low, high): (&str, f64, f64),
    errors: &mut Vec<Diagnostic>,
) {
    let joint = &model.joints[j];
    let limited = run.scenario.robot.joint_limits == JointLimits::Stop && joint.kind != JointKind::Continuous;
    // A goal at a limit that is written in degrees may lie a rounding beyond it.
    let rounding = 1e-9;
    if limited && (low < joint.lower - rounding || high > joint.upper + rounding) {
        let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
        let worst = if low < joint.lower - rounding { low } else { high };
        let (name, lower, upper) = (&joint.name, joint.lower, joint.upper);
        let message =
            format!("{what} `{name}` = {worst:.4} {unit} is outside its range, {lower:.4} to {upper:.4} {unit}");
        let help = "`robot.joint_limits = \"ignore\"` takes the end stops away".to_owned();
        errors.push(run.error_at(key, message, Some(help)));
    }
}

/// Notes joints that tasks ask for positions while their drives do not follow any.
pub(super) fn heard(run: &Run, model: &Model, path: &str, joints: &[JointId], notes: &mut Vec<String>) {
    let commands = |task: &TaskSpec| match task {
        TaskSpec::Script(_) => true,
        TaskSpec::Balance(balance) => balance.control == BalanceControl::Force,
        _ => false,
    };
    let sprung = run.scenario.task.iter().any(commands);
    for &JointId(j) in joints {
        let joint = &model.joints[j];
        let word = match joint.drive.mode {
            DriveMode::Passive => "passive",
            DriveMode::Force if !sprung => "force",
            _ => continue,
        };
        notes.push(format!("{path}: `{}` is in mode `{word}` and does not follow positions", joint.name));
    }
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
