//! Resolves names of a scenario in the robot.

use crate::robot::{Base, DriveMode, JointId, JointKind, LinkId, Model, SoleId};
use crate::scenario::{BalanceControl, Diagnostic, ForceSpec, JointLimits, Run, TaskSpec, segment};
use crate::text::suggest;
use nalgebra::Isometry3;

/// Greatest number of errors reported for one run.
pub(super) const MAX_ERRORS: usize = 50;

/// The first errors, and the number of others.
pub(super) fn limit_errors(mut errors: Vec<Diagnostic>) -> Vec<Diagnostic> {
    if errors.len() > MAX_ERRORS {
        let more = format!("there are {} more errors", errors.len() - MAX_ERRORS);
        errors.truncate(MAX_ERRORS);
        let file = errors[0].file.clone();
        errors.push(Diagnostic::whole_file(file, more));
    }
    errors
}

/// What the robot is called in messages.
const ROBOT: &str = "robot";

/// A mechanism whose names a scenario uses: the robot or an object.
#[derive(Clone, Copy)]
pub(super) struct Owner<'a> {
    pub model: &'a Model,
    /// `robot` or `object`, for messages.
    pub kind: &'static str,
}

impl<'a> Owner<'a> {
    /// The robot.
    pub fn robot(model: &'a Model) -> Self {
        Owner { model, kind: ROBOT }
    }

    /// Name of a link or end effector in events: of an object with its name before it.
    pub fn part(&self, name: &str) -> String {
        if self.kind == ROBOT { name.to_owned() } else { format!("{}/{name}", self.model.name) }
    }
}

/// As "the robot `name`".
impl std::fmt::Display for Owner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the {} `{}`", self.kind, self.model.name)
    }
}

/// Joint indices of named values; unknown names are errors at their keys under `path`.
pub(super) fn joints<'a>(
    model: &Model,
    run: &Run,
    path: &str,
    named: impl Iterator<Item = (&'a String, &'a f64)>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<(JointId, f64)> {
    joints_of(Owner::robot(model), run, path, named, errors)
}

/// Positions of the keyframe with this name and of the joints that follow, or without one the home posture. An unknown name is an error at `key`.
pub(super) fn start_posture(
    owner: Owner,
    run: &Run,
    key: &str,
    name: Option<&String>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<f64> {
    let model = owner.model;
    let Some(name) = name else { return model.home.clone() };
    if let Some(keyframe) = model.keyframes.iter().find(|keyframe| keyframe.name == *name) {
        let mut joints = keyframe.joints.clone();
        for coupling in &model.couplings {
            joints[coupling.joint.0] = coupling.evaluate(joints[coupling.leader.0]).0;
        }
        return joints;
    }
    let help = match model.keyframes.is_empty() {
        true => "only MJCF files have keyframes (`<key>` with a name); `posture` gives positions by joint".to_owned(),
        false => suggest(name, model.keyframes.iter().map(|keyframe| keyframe.name.as_str())),
    };
    errors.push(run.error_at(key, format!("{owner} has no keyframe `{name}`"), Some(help)));
    model.home.clone()
}

/// As [`joints`], of any mechanism.
pub(super) fn joints_of<'a>(
    owner: Owner,
    run: &Run,
    path: &str,
    named: impl Iterator<Item = (&'a String, &'a f64)>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<(JointId, f64)> {
    let model = owner.model;
    let mut found = Vec::new();
    for (name, &value) in named {
        match model.joint(name) {
            Some(id) => found.push((id, value)),
            None => {
                let help = suggest(name, model.joints.iter().map(|j| j.name.as_str()));
                let message = format!("{owner} has no joint `{name}`");
                errors.push(run.error_at_key(&format!("{path}.{}", segment(name)), message, Some(help)));
            }
        }
    }
    found
}

/// Refuses positions from `low` to `high` outside a joint's range, with an error at `key`; `what`
/// names them.
pub(super) fn check_range(
    run: &Run,
    model: &Model,
    key: &str,
    JointId(j): JointId,
    (what, low, high): (&str, f64, f64),
    errors: &mut Vec<Diagnostic>,
) {
    let joint = &model.joints[j];
    let limited = run.scenario.robot.joint_limits == JointLimits::Stop && joint.kind != JointKind::Continuous;
    // A goal at a limit that is written in degrees may exceed it by rounding.
    let rounding = 1e-9;
    if limited && (low < joint.lower - rounding || high > joint.upper + rounding) {
        let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
        let worst = if low < joint.lower - rounding { low } else { high };
        let (name, lower, upper) = (&joint.name, joint.lower, joint.upper);
        let message =
            format!("{what} `{name}` = {worst:.4} {unit} is outside its range, {lower:.4} to {upper:.4} {unit}");
        let help = "`robot.joint_limits = \"ignore\"` removes the end stops".to_owned();
        errors.push(run.error_at(key, message, Some(help)));
    }
}

/// Notes joints that a task commands to positions but whose drives do not follow positions.
pub(super) fn note_ignored_commands(run: &Run, model: &Model, path: &str, joints: &[JointId], notes: &mut Vec<String>) {
    let commands = |task: &TaskSpec| match task {
        TaskSpec::Script(_) => true,
        TaskSpec::Balance(balance) => balance.control == BalanceControl::Force,
        _ => false,
    };
    let has_effort_task = run.scenario.task.iter().any(commands);
    for &JointId(j) in joints {
        let joint = &model.joints[j];
        let mode = match joint.drive.mode {
            DriveMode::Passive => "passive",
            DriveMode::Force if !has_effort_task => "force",
            _ => continue,
        };
        notes.push(format!("{path}: `{}` is in mode `{mode}` and does not follow positions", joint.name));
    }
}

/// The link named at `path`, with the pose of its URDF frame in the carrying link's internal frame;
/// an unknown one is an error there.
fn link(
    owner: Owner,
    run: &Run,
    path: &str,
    name: &str,
    errors: &mut Vec<Diagnostic>,
) -> Option<(LinkId, Isometry3<f64>)> {
    let found = owner.model.link(name);
    if found.is_none() {
        let help = suggest(name, crate::script::links(owner.model).map(|(name, ..)| name).collect::<Vec<_>>());
        errors.push(run.error_at(path, format!("{owner} has no link `{name}`"), Some(help)));
    }
    found
}

/// The frame in which a force acts on the robot or an object.
pub(super) struct GripFrame {
    /// Name of its link or end effector; of an object with its name before it.
    pub name: String,
    /// The carrying link.
    pub link: LinkId,
    /// Its pose in the carrying link's internal frame.
    pub pose: Isometry3<f64>,
}

/// The frame of the link or end effector that the force entry `i` names, or of the root link of the object
/// that it names alone; an unknown or fixed one is an error at its position.
pub(super) fn grip_frame(
    owner: Owner,
    run: &Run,
    i: usize,
    spec: &ForceSpec,
    errors: &mut Vec<Diagnostic>,
) -> Option<GripFrame> {
    let grip = spec.grip()?;
    let model = owner.model;
    if let Some(name) = grip.link {
        let (link, pose) = moving_link(owner, run, &format!("force.{i}.link"), name, errors)?;
        return Some(GripFrame { name: owner.part(name), link, pose });
    }
    let Some(name) = grip.end_effector else { return root_frame(owner, run, i, errors) };
    let found = model.end_effectors.iter().find(|e| e.name == name);
    if found.is_none() {
        let help = match model.end_effectors.is_empty() {
            true => "its robot file has no `[[end_effector]]`".to_owned(),
            false => suggest(name, model.end_effectors.iter().map(|e| e.name.as_str())),
        };
        let message = format!("{owner} has no end effector `{name}`");
        errors.push(run.error_at(&format!("force.{i}.end_effector"), message, Some(help)));
    }
    let found = found?;
    require_moving(owner, run, &format!("force.{i}.end_effector"), name, found.link, errors)?;
    Some(GripFrame { name: owner.part(name), link: found.link, pose: found.pose })
}

/// The frame of the root link of the object that the force entry `i` names; a fixed one is an error there.
pub(super) fn root_frame(owner: Owner, run: &Run, i: usize, errors: &mut Vec<Diagnostic>) -> Option<GripFrame> {
    let root = &owner.model.links[0];
    require_moving(owner, run, &format!("force.{i}.object"), &root.name, LinkId(0), errors)?;
    Some(GripFrame { name: owner.model.name.clone(), link: LinkId(0), pose: root.urdf_frame })
}

/// As [`link`], for links that a force can move: not a fixed root, nor a link welded to it.
pub(super) fn moving_link(
    owner: Owner,
    run: &Run,
    path: &str,
    name: &str,
    errors: &mut Vec<Diagnostic>,
) -> Option<(LinkId, Isometry3<f64>)> {
    let found = link(owner, run, path, name, errors)?;
    require_moving(owner, run, path, name, found.0, errors)?;
    Some(found)
}

/// `None`, with an error at `path`, if the link that carries `name` is fixed.
fn require_moving(
    owner: Owner,
    run: &Run,
    path: &str,
    name: &str,
    link: LinkId,
    errors: &mut Vec<Diagnostic>,
) -> Option<()> {
    if owner.model.base == Base::Fixed && link == LinkId(0) {
        let message = format!("`{name}` of {owner} is fixed and cannot move");
        let names = crate::script::links(owner.model).filter(|(_, id, _)| *id != LinkId(0)).map(|(name, ..)| name);
        let help = format!("links that move: {}", names.collect::<Vec<_>>().join(", "));
        errors.push(run.error_at(path, message, Some(help)));
        return None;
    }
    Some(())
}

/// The sole named at `path`; an unknown one is an error there.
pub(super) fn sole(model: &Model, run: &Run, path: &str, name: &str, errors: &mut Vec<Diagnostic>) -> Option<SoleId> {
    let found = model.soles.iter().position(|s| s.name == name);
    if found.is_none() {
        let help = suggest(name, model.soles.iter().map(|s| s.name.as_str()));
        let message = format!("the robot `{}` has no sole `{name}`", model.name);
        errors.push(run.error_at(path, message, Some(help)));
    }
    found.map(SoleId)
}

/// Indices of named soles; unknown and repeated names are errors at their positions under `path`.
pub(super) fn soles(
    model: &Model,
    run: &Run,
    path: &str,
    named: &[String],
    errors: &mut Vec<Diagnostic>,
) -> Vec<SoleId> {
    let mut found = Vec::new();
    for (i, name) in named.iter().enumerate() {
        let path = format!("{path}.{i}");
        match sole(model, run, &path, name, errors) {
            Some(id) if found.contains(&id) => {
                errors.push(run.error_at(&path, format!("the sole `{name}` is named twice"), None));
            }
            id => found.extend(id),
        }
    }
    found
}
