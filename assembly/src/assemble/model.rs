//! The model of a run's robot, with the changes of the scenario.

use crate::robot;
use crate::robot::adjustments::{self, DriveSettings};
use crate::robot::{DriveMode, Model, Robot};
use crate::scenario::{Diagnostic, JointMode, Run, SoleSpec, segment};

/// The robot's model with the scenario's changes.
pub(super) fn adjusted_model(run: &Run, robot: &Robot, errors: &mut Vec<Diagnostic>) -> Model {
    let spec = &run.scenario.robot;
    let mut model = robot.model.clone();
    let default = DriveSettings {
        mode: Some(mode(spec.joint_default.mode)),
        kp: Some(spec.joint_default.kp),
        kd: Some(spec.joint_default.kd),
        ..DriveSettings::default()
    };
    for (name, joint) in &spec.joint {
        let own = DriveSettings {
            mode: joint.mode.map(mode),
            kp: joint.kp,
            kd: joint.kd,
            effort: joint.effort,
            velocity: joint.velocity,
            armature: joint.armature,
            lag: joint.lag,
            coulomb: joint.friction.map(|f| f.coulomb),
            viscous: joint.friction.map(|f| f.viscous),
            static_friction: joint.friction.map(|f| f.static_.unwrap_or(0.0)),
            stribeck_velocity: joint.friction.and_then(|f| f.stribeck_velocity),
            slip_velocity: joint.friction.and_then(|f| f.slip_velocity),
            stop: joint.stop.map(|s| (s.stiffness, s.damping)),
        };
        // A joint that no robot file configures takes missing keys from the default, as in a robot
        // file.
        let is_unconfigured = model.joint(name).is_some_and(|j| !model.joints[j.0].drive_configured);
        let gains = own.kp.or(own.kd).is_some();
        let settings = match default.mode {
            _ if !is_unconfigured => own,
            // Gains imply a drive.
            Some(DriveMode::Passive) if gains => own.or(DriveSettings { mode: Some(DriveMode::Position), ..default }),
            _ => own.or(default),
        };
        if let Err(e) = adjustments::set_drive(&mut model, name, &settings) {
            errors.push(run.error_at_key(&format!("robot.joint.{}", segment(name)), e.to_string(), None));
        }
    }
    if let Err(e) = adjustments::set_default_drive(&mut model, &default) {
        errors.push(run.error_at("robot.joint_default", e.to_string(), None));
    }
    if let Some(soles) = &spec.soles {
        let convert = |s: &SoleSpec| adjustments::SolePolygon {
            name: s.name.clone(),
            link: s.link.clone(),
            polygon: s.polygon.iter().map(|&p| p.into()).collect(),
        };
        let soles: Vec<_> = soles.iter().map(convert).collect();
        if let Err(e) = adjustments::set_soles(&mut model, &soles) {
            errors.push(run.error_at("robot.soles", e.to_string(), None));
        }
    }
    for (i, load) in spec.payload.iter().enumerate() {
        let position = load.position.into();
        let added = match load.size {
            Some(size) => robot::add_box(&mut model, &load.link, load.mass, position, size),
            None => adjustments::add_payload(&mut model, &load.link, load.mass, position, load.inertia),
        };
        if let Err(e) = added {
            errors.push(run.error_at(&format!("robot.payload.{i}"), e.to_string(), None));
        }
    }
    model
}

fn mode(mode: JointMode) -> DriveMode {
    match mode {
        JointMode::Passive => DriveMode::Passive,
        JointMode::Position => DriveMode::Position,
        JointMode::Force => DriveMode::Force,
        JointMode::Velocity => DriveMode::Velocity,
        JointMode::Kinematic => DriveMode::Kinematic,
    }
}
