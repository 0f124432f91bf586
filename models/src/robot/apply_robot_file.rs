//! Applies a robot file to the model of its URDF.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use toml::Spanned;

use super::adjustments::{DriveSettings, SolePolygon, link_names, make_sole, set_drive};
use super::coupled_joints;
use super::joint_names::joint_index;
use super::link_poses::link_poses;
use super::loop_entries;
use super::model::{DriveMode, EndEffector, Joint, JointId, JointKind, LinkId, Model, Mount, SensorFrame};
use super::notices::Notices;
use super::payload;
use super::robot_error::{FileError, RobotError};
use super::robot_file::{Frame, JointEntry, ModeWord, RobotFile, SoleEntry};
use super::transmission_entries;
use crate::text::pattern::matches;
use crate::text::source::Source;

/// Applies all keys but `model`, `urdf` and `base`. Errors have positions in the robot file.
pub(super) fn apply(
    file: &RobotFile,
    source: &Source,
    model: &mut Model,
    notices: &mut Notices,
) -> Result<(), RobotError> {
    home(file, source, model)?;
    let kinematic = match_kinematic(file, source, model)?;
    drives(file, source, model, &kinematic)?;
    transmission_entries::add(file, source, model)?;
    loop_entries::add(&file.loops, source, model)?;
    payload::weld(&file.payload, source, model)?;
    if let Some(soles) = &file.sole {
        add_soles(soles, source, model, notices)?;
    }
    let end_effectors = frames(&file.end_effector, "end effector", source, model)?.into_iter();
    let end_effector = |SensorFrame { name, mount: Mount { link, pose } }| EndEffector { name, link, pose };
    model.end_effectors = end_effectors.map(end_effector).collect();
    if let Some(sensors) = file.sensors.as_ref().map(Spanned::get_ref) {
        model.sensors.imu = frames(&sensors.imu, "IMU", source, model)?;
        model.sensors.force = frames(&sensors.force, "force sensor", source, model)?;
    }
    Ok(())
}

/// Resolves the frames of one kind, whose names must be unique.
fn frames(
    entries: &[Spanned<Frame>],
    kind: &str,
    source: &Source,
    model: &Model,
) -> Result<Vec<SensorFrame>, RobotError> {
    let mut frames: Vec<SensorFrame> = Vec::new();
    for entry in entries {
        let frame = entry.get_ref();
        let element = format!("{kind} `{}`", frame.name);
        if frames.iter().any(|other| other.name == frame.name) {
            let fault = FileError::new(source, entry.span(), format!("there are two {kind}s named `{}`", frame.name));
            return Err(fault.element(element).expected("a unique name").invalid());
        }
        let (link, pose) = frame_pose(frame, &element, source, model)?;
        frames.push(SensorFrame { name: frame.name.clone(), mount: Mount { link, pose } });
    }
    Ok(frames)
}

/// The carrying link and the frame's pose in its internal frame.
fn frame_pose(
    frame: &Frame,
    element: &str,
    source: &Source,
    model: &Model,
) -> Result<(LinkId, Isometry3<f64>), RobotError> {
    let (link, urdf_frame) = known_link(&frame.link, element, source, model)?;
    let position = frame.position.as_ref().map_or([0.0; 3], |p| *p.get_ref());
    if let Some(span) = frame.position.as_ref().filter(|_| !position.iter().all(|x| x.is_finite())).map(Spanned::span) {
        let fault = FileError::new(source, span, format!("position of {element} is not finite"));
        return Err(fault.element(element).expected("three finite numbers").invalid());
    }
    let [roll, pitch, yaw] = frame.rpy.map_or([0.0; 3], |rpy| rpy.map(|angle| angle.value));
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok((link, urdf_frame * Isometry3::from_parts(Vector3::from(position).into(), rotation)))
}

/// Greatest difference between a given home and that of the coupling it must follow, rad or m.
const SAME_HOME: f64 = 1e-6;

fn home(file: &RobotFile, source: &Source, model: &mut Model) -> Result<(), RobotError> {
    for (name, angle) in &file.home {
        let index = joint_index(name, source, model)?;
        let joint = &model.joints[index];
        let element = format!("home of joint `{}`", joint.name);
        if joint.kind == JointKind::Prismatic && angle.get_ref().has_unit {
            let fault =
                FileError::new(source, angle.span(), format!("joint `{}` is prismatic and has no angle", joint.name));
            return Err(fault.element(element).expected("a number in m").invalid());
        }
        let value = angle.get_ref().value;
        if value < joint.lower || value > joint.upper {
            let fault =
                FileError::new(source, angle.span(), format!("{element} is outside the joint's limits")).found(value);
            let expected = format!("{:.6} to {:.6}", joint.lower, joint.upper);
            return Err(fault.element(element).expected(expected).invalid());
        }
        model.home[index] = value;
    }
    coupled_joints::set_homes(model);
    for (name, angle) in &file.home {
        let index = joint_index(name, source, model)?;
        let (given, home) = (angle.get_ref().value, model.home[index]);
        if (given - home).abs() > SAME_HOME {
            let leader = model.coupling_of(JointId(index)).map_or(index, |coupling| coupling.leader.0);
            let message = format!("joint `{}` follows `{}`", name.get_ref(), model.joints[leader].name);
            let fault = FileError::new(source, angle.span(), message).found(given);
            let fault = fault.element(format!("home of joint `{}`", name.get_ref()));
            return Err(fault.expected(format!("{home}, or no home of its own")).invalid());
        }
    }
    Ok(())
}

/// For each joint, true if a pattern of `kinematic` matches it.
fn match_kinematic(file: &RobotFile, source: &Source, model: &Model) -> Result<Vec<bool>, RobotError> {
    let mut matched = vec![false; model.joints.len()];
    for pattern in file.kinematic.iter().flatten() {
        let mut has_match = false;
        // The name of a following joint is refused with the drives.
        let of_joints = matched.iter_mut().zip(&model.joints).enumerate();
        let is_meant = |j: usize, joint: &Joint| {
            matches(pattern.get_ref(), &joint.name) && model.is_meant(pattern.get_ref(), JointId(j))
        };
        for (_, (matched, joint)) in of_joints.filter(|(j, (_, joint))| is_meant(*j, joint)) {
            (has_match, *matched) = (true, true);
            let own = file.joint.get(joint.name.as_str()).and_then(|entry| entry.get_ref().mode.as_ref());
            if let Some(mode) = own.filter(|mode| *mode.get_ref() != ModeWord::Kinematic) {
                let message = format!("joint `{}` is matched by `{}` of `kinematic`", joint.name, pattern.get_ref());
                let fault = FileError::new(source, mode.span(), message).element(format!("joint `{}`", joint.name));
                return Err(fault.expected("no other mode").invalid());
            }
        }
        if !has_match {
            let message = format!("no moving joint of the URDF matches `{}`", pattern.get_ref());
            let known = model.joints.iter().map(|j| j.name.as_str());
            return Err(FileError::new(source, pattern.span(), message)
                .element("kinematic")
                .suggest(pattern.get_ref(), known)
                .invalid());
        }
    }
    Ok(matched)
}

fn drives(file: &RobotFile, source: &Source, model: &mut Model, kinematic: &[bool]) -> Result<(), RobotError> {
    for name in file.joint.keys() {
        joint_index(name, source, model)?;
    }
    let default = match &file.joint_default {
        Some(entry) => settings(entry.get_ref(), "joint_default", source)?,
        None => DriveSettings::default(),
    };
    let names: Vec<String> = model.joints.iter().map(|j| j.name.clone()).collect();
    // A drive by default would act against the joint that another one follows.
    let of_followers = DriveSettings { mode: None, kp: None, kd: None, lag: None, ..default };
    for (j, (name, kinematic)) in names.into_iter().zip(kinematic).enumerate() {
        let own = file.joint.get(name.as_str());
        let default = if model.coupling_of(JointId(j)).is_some() { of_followers } else { default };
        let span = own.or(file.joint_default.as_ref()).map_or(0..0, Spanned::span);
        let mut own = match own {
            Some(entry) => settings(entry.get_ref(), &format!("joint `{name}`"), source)?,
            None => DriveSettings::default(),
        };
        if *kinematic {
            own.mode = Some(DriveMode::Kinematic);
        }
        let element = format!("joint `{name}`");
        set_drive(model, &name, &own.or(default)).map_err(|error| with_position(span, &element, error, source))?;
    }
    Ok(())
}

/// Adds the position in the robot file to an error of a value.
fn with_position(span: std::ops::Range<usize>, element: &str, error: RobotError, source: &Source) -> RobotError {
    match error {
        RobotError::BadValue { subject, found, expected } => {
            FileError::new(source, span, subject).element(element).found(found).expected(expected).invalid()
        }
        other => other,
    }
}

/// Checks the values of a drive's table.
fn settings(entry: &JointEntry, element: &str, source: &Source) -> Result<DriveSettings, RobotError> {
    let checked = |key: &str, value: &Option<Spanned<f64>>, holds: &dyn Fn(f64) -> bool, expected: &str| match value {
        Some(v) if !(v.get_ref().is_finite() && holds(*v.get_ref())) => {
            let fault =
                FileError::new(source, v.span(), format!("{key} of {element} cannot be used")).found(v.get_ref());
            Err(fault.element(element).expected(expected).invalid())
        }
        Some(v) => Ok(Some(*v.get_ref())),
        None => Ok(None),
    };
    let number = |key: &str, value: &_| checked(key, value, &|v| v >= 0.0, "a finite number, not negative");
    let above = |key: &str, value: &_| checked(key, value, &|v| v > 0.0, "a finite number above 0");
    let mode = entry.mode.as_ref().map(|mode| match mode.get_ref() {
        ModeWord::Position => DriveMode::Position,
        ModeWord::Force => DriveMode::Force,
        ModeWord::Passive => DriveMode::Passive,
        ModeWord::Velocity => DriveMode::Velocity,
        ModeWord::Kinematic => DriveMode::Kinematic,
    });
    let friction = entry.friction.clone().unwrap_or_default();
    Ok(DriveSettings {
        mode,
        kp: number("kp", &entry.kp)?,
        kd: number("kd", &entry.kd)?,
        effort: number("effort", &entry.effort)?,
        velocity: number("velocity", &entry.velocity)?,
        coulomb: number("friction.coulomb", &friction.coulomb)?,
        viscous: number("friction.viscous", &friction.viscous)?,
        static_friction: number("friction.static", &friction.static_)?,
        stribeck_velocity: above("friction.stribeck_velocity", &friction.stribeck_velocity)?,
        slip_velocity: above("friction.slip_velocity", &friction.slip_velocity)?,
        stop: match &entry.stop {
            None => None,
            Some(stop) => {
                let stiffness = above("stop.stiffness", &Some(stop.stiffness.clone()))?.unwrap_or_default();
                Some((stiffness, number("stop.damping", &stop.damping)?.unwrap_or_default()))
            }
        },
        armature: number("armature", &entry.armature)?,
        lag: number("lag", &entry.lag)?,
    })
}

fn add_soles(
    soles: &[Spanned<SoleEntry>],
    source: &Source,
    model: &mut Model,
    notices: &mut Notices,
) -> Result<(), RobotError> {
    let poses = link_poses(model, &model.home);
    for entry in soles {
        let sole = entry.get_ref();
        let element = format!("sole `{}`", sole.name);
        if model.soles.iter().any(|s| s.name == sole.name) {
            let fault = FileError::new(source, entry.span(), format!("there are two soles named `{}`", sole.name));
            return Err(fault.element(element).expected("a unique name").invalid());
        }
        known_link(&sole.link, &element, source, model)?;
        let spec = SolePolygon {
            name: sole.name.clone(),
            link: sole.link.get_ref().clone(),
            polygon: sole.polygon.get_ref().iter().map(|p| Vector3::from(*p)).collect(),
        };
        let (new, reversed) = make_sole(model, &poses, &spec)
            .map_err(|error| with_position(sole.polygon.span(), &element, error, source))?;
        if reversed {
            let message = format!("{element} runs clockwise seen from above: the order of its vertices is reversed");
            notices.info(source, sole.polygon.span().start, message);
        }
        model.soles.push(new);
    }
    Ok(())
}

/// Notes force sensors that are not read: those on links without a sole, and all but the first of a
/// link. Requires the soles.
pub(super) fn note_unread_force_sensors(file: &RobotFile, source: &Source, model: &Model, notices: &mut Notices) {
    let entries = file.sensors.iter().flat_map(|s| &s.get_ref().force);
    for (i, (entry, sensor)) in entries.zip(&model.sensors.force).enumerate() {
        let link = sensor.mount.link;
        let first = model.sensors.force[..i].iter().find(|other| other.mount.link == link);
        let reason = match first {
            Some(first) => format!("`{}` is on the same link", first.name),
            None if model.soles.iter().any(|sole| sole.link == link) => continue,
            None => format!("link `{}` has no sole", model.links[link.0].name),
        };
        notices.info(source, entry.span().start, format!("force sensor `{}` is not read: {reason}", sensor.name));
    }
}

/// The link of that name with the pose of its URDF frame in its internal frame.
pub(super) fn known_link(
    name: &Spanned<String>,
    element: &str,
    source: &Source,
    model: &Model,
) -> Result<(LinkId, Isometry3<f64>), RobotError> {
    if let Some(found) = model.link(name.get_ref()) {
        return Ok(found);
    }
    let fault = FileError::new(source, name.span(), format!("{element} names an unknown link"))
        .found(format!("`{}`", name.get_ref()));
    let fault = fault.element(element).expected("the name of a <link> of the URDF");
    Err(fault.suggest(name.get_ref(), link_names(model)).invalid())
}
