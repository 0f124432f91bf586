//! Motions of a joint as chains of simple joints.

use nalgebra::Vector3;

use super::convert;
use crate::robot::model::{Joint, JointKind};
use crate::robot::moving_links::free_joint;
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;
use crate::sdf::{Axis, ResolvedJoint, SdfError};
use crate::text::suggest::nearest;

/// Types that are available.
const TYPES: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "ball", "universal", "revolute2"];
/// Types of the format that are not.
const OTHERS: [&str; 2] = ["screw", "gearbox"];

/// The motions of a joint, parent's side first, with their unit axes in the joint's frame; none for
/// a fixed one.
pub(super) fn motions(joint: &ResolvedJoint, notices: &mut Notices) -> Result<Vec<(Joint, Vector3<f64>)>, RobotError> {
    let (name, kind) = (joint.name.as_str(), joint.joint.kind.as_str());
    let error = |message: String| SdfError::new(joint.joint.at.clone(), message).element(format!("joint `{name}`"));
    let axis = |k: usize, motion: JointKind, own: &str| -> Result<(Joint, Vector3<f64>), RobotError> {
        let Some((written, direction)) = joint.joint.axes.get(k).zip(joint.axes.get(k)) else {
            let tag = if k == 0 { "<axis>" } else { "<axis2>" };
            return Err(convert(error(format!("joint `{name}` has no {tag}")).expected(tag)));
        };
        Ok((simple(own.to_owned(), motion, written), *direction))
    };
    match kind {
        "fixed" => Ok(Vec::new()),
        "revolute" => Ok(vec![axis(0, JointKind::Revolute, name)?]),
        "continuous" => Ok(vec![axis(0, JointKind::Continuous, name)?]),
        "prismatic" => Ok(vec![axis(0, JointKind::Prismatic, name)?]),
        "universal" | "revolute2" => {
            let (first, second) = (format!("{name}/axis"), format!("{name}/axis2"));
            note(joint, &format!("`{first}`, `{second}`"), notices);
            Ok(vec![axis(0, JointKind::Revolute, &first)?, axis(1, JointKind::Revolute, &second)?])
        }
        "ball" => {
            let names = ["yaw", "pitch", "roll"].map(|part| format!("{name}/{part}"));
            let list = names.clone().map(|n| format!("`{n}`")).join(", ");
            note(joint, &format!("{list}, passive and unlimited; it must not pitch by 90 degrees"), notices);
            let axes = [Vector3::z(), Vector3::y(), Vector3::x()];
            let turn = |(name, axis)| (free_joint(name, JointKind::Continuous), axis);
            Ok(names.into_iter().zip(axes).map(turn).collect())
        }
        _ if OTHERS.contains(&kind) => {
            let error = error(format!("joint `{name}`: {kind} joints are not available"));
            Err(convert(error.expected(format!("one of {}", TYPES.join(", "))).not_available()))
        }
        _ => {
            let error = error(format!("joint `{name}` has an unknown type")).found(format!("`{kind}`"));
            let error = error.expected(format!("one of {}", TYPES.join(", ")));
            let near = nearest(kind, TYPES);
            Err(convert(match near {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error,
            }))
        }
    }
}

fn note(joint: &ResolvedJoint, chain: &str, notices: &mut Notices) {
    let at = &joint.joint.at;
    let message = format!("joint `{}` is modelled as the chain of {chain}", joint.name);
    notices.warning(&at.source, at.span.start, message);
}

/// One motion with its limits and friction. A revolute joint without limits is continuous.
fn simple(name: String, kind: JointKind, axis: &Axis) -> Joint {
    let is_limited = kind != JointKind::Continuous && (axis.lower.is_some() || axis.upper.is_some());
    let kind = if kind == JointKind::Revolute && !is_limited { JointKind::Continuous } else { kind };
    let limit = |value: Option<f64>, none: f64| value.filter(|_| is_limited).unwrap_or(none);
    Joint {
        lower: limit(axis.lower, f64::NEG_INFINITY),
        upper: limit(axis.upper, f64::INFINITY),
        velocity_limit: axis.velocity.unwrap_or(f64::INFINITY),
        effort_limit: axis.effort.unwrap_or(f64::INFINITY),
        damping: axis.damping,
        friction: axis.friction,
        drive_configured: false,
        ..free_joint(name, kind)
    }
}
