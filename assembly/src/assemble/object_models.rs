//! Objects that are mechanisms: a robot file or URDF with joints, which are free or held by servos.

use super::bodies::link_shapes;
use super::closed_start::{Given, close};
use super::names::{self, Owner};
use super::objects::{Object, initial_state, own_friction};
use crate::robot::adjustments::{self, DriveSettings};
use crate::robot::{self, Base, DriveMode, JointId, JointKind, Model, Robot, RobotError};
use crate::scenario::{Diagnostic, Diagnostics, JointLimits, ModelObject, ObjectEntry, Run, segment};
use crate::sim::plant::ObjectSetup;
use crate::task::Command;
use crate::text::pattern::matches;
use crate::text::suggest;
use std::sync::Arc;

/// Loads the models of a run's objects from their files, in their order.
///
/// # Errors
/// A file that cannot be read or does not describe a mechanism, at the key that names it.
pub fn load(run: &Run) -> Result<Vec<Arc<Robot>>, Diagnostics> {
    let load = |(i, path): (usize, std::path::PathBuf)| {
        let error =
            |error: RobotError| Diagnostics(vec![run.error_at(&format!("object.{i}.model"), error.to_string(), None)]);
        robot::load(&path).map(Arc::new).map_err(error)
    };
    run.object_models().map(load).collect()
}

/// Object `i` with this robot; what does not fit it is an error at its position.
pub(super) fn object(
    run: &Run,
    i: usize,
    name: String,
    spec: &ModelObject,
    entry: &ObjectEntry,
    robot: &Robot,
    errors: &mut Vec<Diagnostic>,
) -> Object {
    let path = format!("object.{i}");
    let mut model = robot.model.clone();
    model.name.clone_from(&name);
    if model.base == Base::Fixed {
        for (key, velocity) in
            [("linear_velocity", entry.linear_velocity), ("angular_velocity", entry.angular_velocity)]
        {
            if velocity != [0.0; 3] {
                let message = format!("the object `{name}` is fixed to the world and cannot have `{key}`");
                let help = "`velocity` gives the velocities of its joints".to_owned();
                errors.push(run.error_at(&format!("{path}.{key}"), message, Some(help)));
            }
        }
    }
    hold(run, &path, spec, &mut model, errors);
    let mut state = initial_state(&model, entry);
    let owner = Owner { model: &model, kind: "object" };
    let base = names::start_posture(owner, run, &format!("{path}.keyframe"), spec.keyframe.as_ref(), errors);
    state.joints.copy_from_slice(&base);
    let posture_key = format!("{path}.posture");
    let posture = names::joints_of(owner, run, &posture_key, spec.posture.iter(), errors);
    for &(id, q) in &posture {
        check_range(run, spec, &model, (&path, "posture"), id.0, q, errors);
        state.joints[id.0] = q;
    }
    let nb = model.nb();
    let velocity_key = format!("{path}.velocity");
    let velocity = names::joints_of(owner, run, &velocity_key, spec.velocity.iter(), errors);
    for &(id, qd) in &velocity {
        state.v[nb + id.0] = qd;
    }
    let (posture_key, velocity_key) = (posture_key.as_str(), velocity_key.as_str());
    let model_key = format!("{path}.model");
    let given =
        Given { base: &base, posture: &posture, posture_key, velocity: &velocity, velocity_key, model_key: &model_key };
    close(run, &model, &given, &mut state, errors);
    let mut held = state.joints.clone();
    for (id, q) in names::joints_of(owner, run, &format!("{path}.target"), spec.target.iter(), errors) {
        let joint = &model.joints[id.0];
        if joint.drive.mode != DriveMode::Position {
            let message = format!("the joint `{}` of the object `{name}` has no servo that could hold it", joint.name);
            let key = format!("{path}.target.{}", segment(&joint.name));
            let help = "add one: `servo = [{ stiffness = .., damping = .. }]`".to_owned();
            errors.push(run.error_at_key(&key, message, Some(help)));
        }
        check_range(run, spec, &model, (&path, "target"), id.0, q, errors);
        held[id.0] = q;
    }
    let bodies = link_shapes(&model, robot.self_collision.resolution).into_iter();
    let bodies = bodies.map(|body| (body.link, body.shape)).collect();
    let command = Command::hold(&model, &held);
    let joint_stops = spec.joint_limits == JointLimits::Stop;
    let friction = own_friction(entry);
    Object { setup: ObjectSetup { name, model: Arc::new(model), state, command, joint_stops }, bodies, friction }
}

/// Gives joints the servos of the entry. A joint that would follow a command exactly is an error: an
/// object has no tasks.
fn hold(run: &Run, path: &str, spec: &ModelObject, model: &mut Model, errors: &mut Vec<Diagnostic>) {
    let names: Vec<String> = model.joints.iter().map(|joint| joint.name.clone()).collect();
    for (k, servo) in spec.servo.iter().enumerate() {
        let settings = DriveSettings {
            mode: Some(DriveMode::Position),
            kp: Some(servo.stiffness),
            kd: Some(servo.damping),
            ..DriveSettings::default()
        };
        let mut has_match = false;
        for (j, name) in names.iter().enumerate().filter(|(_, name)| matches(&servo.joints, name)) {
            if !model.is_meant(&servo.joints, JointId(j)) {
                continue;
            }
            has_match = true;
            if let Err(error) = adjustments::set_drive(model, name, &settings) {
                errors.push(run.error_at(&format!("{path}.servo.{k}"), error.to_string(), None));
            }
        }
        if !has_match {
            let message = format!("no joint of the object `{}` matches {:?}", model.name, servo.joints);
            let help = match names.is_empty() {
                true => "its model has no joints".to_owned(),
                false => suggest(&servo.joints, names.iter().map(String::as_str)),
            };
            errors.push(run.error_at(&format!("{path}.servo.{k}"), message, Some(help)));
        }
    }
    if let Some(joint) = model.joints.iter().find(|joint| joint.drive.mode == DriveMode::Kinematic) {
        let message = format!(
            "the joint `{}` of the object `{}` is `kinematic` in its model, but nothing commands objects",
            joint.name, model.name
        );
        let help = "a servo can hold it instead: `servo = [{ stiffness = .., damping = .. }]`".to_owned();
        errors.push(run.error_at(&format!("{path}.model"), message, Some(help)));
    }
}

/// Refuses a position outside a joint's range, at the entry `key` of that joint.
fn check_range(
    run: &Run,
    spec: &ModelObject,
    model: &Model,
    (path, key): (&str, &str),
    j: usize,
    q: f64,
    errors: &mut Vec<Diagnostic>,
) {
    let joint = &model.joints[j];
    let is_limited = spec.joint_limits == JointLimits::Stop && joint.kind != JointKind::Continuous;
    // A limit that is written in degrees may be exceeded by rounding.
    if !is_limited || (joint.lower - 1e-9..=joint.upper + 1e-9).contains(&q) {
        return;
    }
    let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
    let (name, lower, upper) = (&joint.name, joint.lower, joint.upper);
    let message = format!("`{name}` = {q:.4} {unit} is outside its range, {lower:.4} to {upper:.4} {unit}");
    let help = format!("`{path}.joint_limits = \"ignore\"` removes the end stops");
    errors.push(run.error_at(&format!("{path}.{key}.{}", segment(name)), message, Some(help)));
}
