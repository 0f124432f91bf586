//! Actuators on joints: drive, effort limit and lag.
//!
//! MuJoCo's force of an actuator is `p = g u + b_0 + b_1 l + b_2 l'` with the control u and the
//! length `l = gear q`; the joint receives `gear p` ([MuJoCo], computation, actuation model). So a
//! servo has the gains `-gear^2 b_1` and `-gear^2 b_2` at the joint, and a motor the effort
//! `gear g u`.

use super::classes::{ACTUATORS, Classes};
use super::document::Id;
use super::ignored::Ignored;
use super::joints::{Kind, larger};
use super::moving_tree::{Context, Parts};
use super::view::View;
use crate::robot::model::{Drive, DriveMode};
use crate::robot::robot_error::RobotError;

/// Gains, biases and activation after defaults.
struct Law {
    gain: f64,
    bias: [f64; 3],
    is_fixed_gain: bool,
    has_bias: bool,
    dynamics: &'static str,
    time_constant: f64,
}

/// A servo whose damping follows from a damping ratio and the inertia at the reference positions.
pub(super) struct RatioServo {
    pub joint: usize,
    pub ratio: f64,
}

/// Applies all actuators. Joints without one are passive if any joint has one.
pub(super) fn apply(
    context: &Context,
    classes: &Classes,
    parts: &mut Parts,
    ignored: &mut Ignored,
) -> Result<Vec<RatioServo>, RobotError> {
    let document = context.document;
    let mut driven: Vec<bool> = vec![false; parts.joints.len()];
    let mut ratios = Vec::new();
    let all = document.section("actuator").flat_map(|section| document.children(section));
    for &id in all.filter(|&&id| ACTUATORS.contains(&document.tag(id))) {
        let view = classes.view(id, None)?;
        let Some(joint) = transmission(&view, parts, ignored)? else { continue };
        let tag = document.tag(id);
        if !matches!(tag, "general" | "motor" | "position" | "velocity") {
            ignored.warning(id, format!("actuators <{tag}> are ignored"));
            continue;
        }
        let law = law(&view)?;
        apply_one(context, &view, &law, joint, parts, &mut driven, &mut ratios, ignored)?;
    }
    if driven.contains(&true) {
        // A motor leaves the servo to the scenario.
        for (joint, _) in parts.joints.iter_mut().zip(&driven).filter(|(_, driven)| !**driven) {
            joint.drive_configured = true;
        }
    }
    Ok(ratios)
}

/// The joint of the model that an actuator drives; `None` if it is not on one.
fn transmission(view: &View, parts: &Parts, ignored: &mut Ignored) -> Result<Option<usize>, RobotError> {
    let id = view.id();
    let Some(attribute) = ["joint", "jointinparent"].into_iter().find(|a| view.has(a)) else {
        let other = ["tendon", "site", "cranksite", "body"].into_iter().find(|a| view.has(a));
        ignored.warning(id, format!("actuators on a {} are ignored", other.unwrap_or("nothing")));
        return Ok(None);
    };
    let name = view.required(attribute)?;
    let Some(joint) = parts.file_joints.iter().find(|j| j.name == name) else {
        let known = parts.file_joints.iter().map(|j| j.name.as_str());
        return Err(view.fault(attribute, "the name of a joint").suggest(name, known).invalid());
    };
    match joint.kind {
        Kind::Hinge | Kind::Slide if joint.first.is_none() => {
            ignored.warning(id, "actuators of bodies that are left out are ignored");
            Ok(None)
        }
        Kind::Hinge | Kind::Slide => Ok(joint.first),
        _ => {
            ignored.warning(id, "actuators on ball and free joints are ignored");
            Ok(None)
        }
    }
}

/// Reads the law from the outermost class to the element itself, as MuJoCo applies them.
fn law(view: &View) -> Result<Law, RobotError> {
    let mut law =
        Law { gain: 1.0, bias: [0.0; 3], is_fixed_gain: true, has_bias: false, dynamics: "none", time_constant: 1.0 };
    for &id in view.levels.iter().rev() {
        let level = View::bare(view.document, id);
        match view.document.tag(id) {
            "motor" => {
                law = Law { gain: 1.0, bias: [0.0; 3], is_fixed_gain: true, has_bias: false, dynamics: "none", ..law };
            }
            "position" => {
                law.gain = level.number("kp")?.unwrap_or(law.gain);
                (law.is_fixed_gain, law.has_bias) = (true, true);
                law.bias[1] = -law.gain;
                if let Some(kv) = level.number("kv")? {
                    law.bias[2] = -kv;
                }
                // A positive number is the ratio, until the inertia is known.
                if let Some(ratio) = level.number("dampratio")? {
                    law.bias[2] = ratio;
                }
                if let Some(time) = level.number("timeconst")? {
                    (law.time_constant, law.dynamics) = (time, if time > 0.0 { "filterexact" } else { "none" });
                }
            }
            "velocity" => {
                law.gain = level.number("kv")?.unwrap_or(1.0);
                law.bias = [0.0, 0.0, -law.gain];
                (law.is_fixed_gain, law.has_bias, law.dynamics) = (true, true, "none");
            }
            "general" => general(&level, &mut law)?,
            _ => {}
        }
    }
    Ok(law)
}

fn general(level: &View, law: &mut Law) -> Result<(), RobotError> {
    if let Some(list) = level.list("gainprm", 1, 20)? {
        law.gain = list[0];
    }
    if let Some(list) = level.list("biasprm", 1, 20)? {
        let count = list.len().min(3);
        law.bias[..count].copy_from_slice(&list[..count]);
    }
    if let Some(list) = level.list("dynprm", 1, 20)? {
        law.time_constant = list[0];
    }
    let user = ["user", "muscle", "dcmotor", "so3", "pid"];
    if let Some(word) = level.word("gaintype", &[&["fixed", "affine"][..], &user].concat())? {
        law.is_fixed_gain = word == "fixed";
    }
    if let Some(word) = level.word("biastype", &[&["none", "affine"][..], &user].concat())? {
        law.has_bias = word != "none";
        law.is_fixed_gain &= matches!(word, "none" | "affine");
    }
    let words = ["none", "integrator", "filter", "filterexact"];
    if let Some(word) = level.word("dyntype", &[&words[..], &user].concat())? {
        law.dynamics = word;
    }
    Ok(())
}

#[expect(clippy::too_many_arguments, reason = "the state of one pass over the actuators")]
fn apply_one(
    context: &Context,
    view: &View,
    law: &Law,
    index: usize,
    parts: &mut Parts,
    driven: &mut [bool],
    ratios: &mut Vec<RatioServo>,
    ignored: &mut Ignored,
) -> Result<(), RobotError> {
    let id: Id = view.id();
    let joint = &mut parts.joints[index];
    let [gear, ..] = view.overlay("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let [b0, b1, b2] = if law.has_bias { law.bias } else { [0.0; 3] };
    let is_filter = matches!(law.dynamics, "filter" | "filterexact");
    let square = gear * gear;
    let mode = match (b1, b2) {
        _ if !law.is_fixed_gain || !(is_filter || law.dynamics == "none") || gear == 0.0 || law.gain == 0.0 => None,
        (0.0, 0.0) if b0 == 0.0 => Some(DriveMode::Force),
        (0.0, kv) if kv < 0.0 && b0 == 0.0 => Some(DriveMode::Velocity),
        (kp, kv) if kp < 0.0 && (kv <= 0.0 || law.gain == -kp) => Some(DriveMode::Position),
        _ => None,
    };
    let Some(mode) = mode else {
        ignored.warning(id, "actuators <general> that are no motor, position or velocity servo are ignored");
        return Ok(());
    };
    let before = joint.drive;
    let added = Drive { mode, kp: -b1 * square, kd: -b2.min(0.0) * square };
    joint.drive = match (driven[index], before.mode, mode) {
        (false, ..) => added,
        // A position servo without damping and a velocity servo form one.
        (true, DriveMode::Position, DriveMode::Velocity) | (true, DriveMode::Velocity, DriveMode::Position) => {
            Drive { mode: DriveMode::Position, kp: before.kp + added.kp, kd: before.kd + added.kd }
        }
        _ => {
            ignored.warning(id, "a joint has two actuators: the second one is ignored");
            return Ok(());
        }
    };
    driven[index] = true;
    joint.drive_configured = mode != DriveMode::Force;
    if mode == DriveMode::Position && b2 > 0.0 {
        ratios.push(RatioServo { joint: index, ratio: b2 });
    }
    if mode == DriveMode::Position && (law.gain != -b1 || b0 != 0.0) {
        ignored.note(id, "the control of an actuator is scaled; here the command is the position of the joint");
    }
    if mode != DriveMode::Force && is_filter {
        ignored.warning(id, "the filter of a servo's command (timeconst) is ignored");
    } else if is_filter {
        joint.lag = law.time_constant.max(0.0);
    }
    let autolimits = context.compiler.autolimits;
    let mut limit = |low: f64, high: f64, name: &str| {
        joint.effort_limit = joint.effort_limit.min(gear.abs() * larger(low, high, id, name, ignored));
    };
    if let Some([low, high]) = view.range("forcerange", "forcelimited", autolimits)? {
        limit(low, high, "forcerange");
    }
    if let Some([low, high]) = view.range("ctrlrange", "ctrllimited", autolimits)? {
        match mode {
            DriveMode::Force => limit(law.gain * low, law.gain * high, "ctrlrange"),
            _ => ignored.note(id, "`ctrlrange` of a servo is ignored: the task limits its commands"),
        }
    }
    Ok(())
}
