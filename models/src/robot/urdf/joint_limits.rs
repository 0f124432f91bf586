//! Motion, limits and friction of a URDF joint, checked.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;
use roxmltree::Node;
use urdf_rs::JointType;

use super::xml::{Xml, child};
use crate::robot::friction::{SLIP_SPEED, STRIBECK_SPEED};
use crate::robot::model::{Drive, Joint, JointKind};
use crate::robot::moving_links::NO_LIMIT;
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;
use crate::text::suggest::nearest;

const KNOWN_TYPES: [&str; 6] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

/// Refuses joint types that cannot be simulated; called before `urdf-rs` reports them without a
/// position.
pub(super) fn check_type(xml: &Xml, node: Node) -> Result<(), RobotError> {
    let name = node.attribute("name").unwrap_or_default();
    let kind = node.attribute("type").unwrap_or_default();
    if KNOWN_TYPES.contains(&kind) {
        return Ok(());
    }
    let expected = format!("one of {}", KNOWN_TYPES.join(", "));
    if kind == "spherical" {
        let fault = xml.attribute_fault(node, "type", format!("joint `{name}`: {kind} joints are not available"));
        let help = "build it from revolute and prismatic joints with light links between them";
        return Err(fault.expected(expected).help(help).not_available());
    }
    let fault = xml.attribute_fault(node, "type", format!("joint `{name}` has an unknown type"));
    Err(fault.expected(expected).suggest(kind, KNOWN_TYPES).invalid())
}

/// A joint that URDF lets follow another: `q = multiplier q_of + offset`.
#[derive(Clone, PartialEq, Debug)]
pub(in crate::robot) struct Mimic {
    /// The following joint.
    pub joint: String,
    /// The joint it follows.
    pub of: String,
    pub multiplier: f64,
    pub offset: f64,
    /// Position of the element in the file.
    pub at: usize,
}

/// The `<mimic>` of a joint.
pub(super) fn mimic(xml: &Xml, node: Node, notices: &mut Notices) -> Option<Mimic> {
    let mimic = child(node, "mimic")?;
    let joint = node.attribute("name").unwrap_or_default().to_owned();
    let at = mimic.range().start;
    if node.attribute("type") == Some("fixed") {
        notices.info(xml.source, at, format!("<mimic> of the fixed joint `{joint}` is ignored"));
        return None;
    }
    let of = mimic.attribute("joint").unwrap_or_default().to_owned();
    let number = |name, default| mimic.attribute(name).and_then(|text| text.trim().parse().ok()).unwrap_or(default);
    Some(Mimic { joint, of, multiplier: number("multiplier", 1.0), offset: number("offset", 0.0), at })
}

/// Greatest number of joints of a ring that a message names.
const MAX_NAMED: usize = 20;

/// Removes mimics that cannot be followed, with a warning: those of joints that do not exist, and
/// rings of joints.
pub(super) fn remove_invalid_mimics(mimics: &mut Vec<Mimic>, xml: &Xml, notices: &mut Notices) {
    let leaders: HashMap<&str, &str> = mimics.iter().rev().map(|m| (m.joint.as_str(), m.of.as_str())).collect();
    let node_of = |joint: &str| xml.named("joint", joint);
    let mut invalid = HashSet::new();
    for Mimic { joint, of: leader, .. } in &*mimics {
        let (mut chain, mut visited): (Vec<&str>, HashSet<&str>) = (vec![joint], HashSet::from([joint.as_str()]));
        let mut next = Some(leader.as_str());
        while let Some(name) = next.filter(|name| visited.insert(name)) {
            chain.push(name);
            next = leaders.get(name).copied();
        }
        let message = if node_of(leader) == xml.robot {
            let help = nearest(
                leader,
                xml.robot.children().filter(|n| n.has_tag_name("joint")).filter_map(|n| n.attribute("name")),
            );
            let help = help.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            format!("joint `{joint}` mimics `{leader}`, which is not a joint of the robot{help}")
        } else if next == Some(joint) {
            let ring: Vec<String> = chain.iter().chain([&next.unwrap_or_default()]).map(|j| format!("`{j}`")).collect();
            let more = if ring.len() > MAX_NAMED { ", ..." } else { "" };
            format!("joints mimic each other in a ring: {}{more}", ring[..ring.len().min(MAX_NAMED)].join(", "))
        } else {
            continue;
        };
        let at = child(node_of(joint), "mimic").unwrap_or(xml.robot).range().start;
        notices.warning(xml.source, at, format!("{message}: `{joint}` is independent"));
        invalid.insert(joint.clone());
    }
    mimics.retain(|m| !invalid.contains(&m.joint));
}

/// The limit, infinite from [`NO_LIMIT`] on.
fn unlimited(limit: f64) -> f64 {
    if limit.abs() >= NO_LIMIT { limit.signum() * f64::INFINITY } else { limit }
}

/// The joint without its drive. Errors: one limit absent, lower limit above the upper one.
pub(super) fn joint(xml: &Xml, joint: &urdf_rs::Joint, notices: &mut Notices) -> Result<Joint, RobotError> {
    let name = &joint.name;
    let node = xml.named("joint", name);
    let limit = child(node, "limit");
    let has = |attribute: &str| limit.and_then(|l| l.attribute(attribute)).is_some();
    let is_bounded = has("lower") || has("upper");
    let kind = match joint.joint_type {
        JointType::Continuous => JointKind::Continuous,
        JointType::Prismatic => JointKind::Prismatic,
        _ if !is_bounded => JointKind::Continuous,
        _ => JointKind::Revolute,
    };
    let (mut lower, mut upper) = (f64::NEG_INFINITY, f64::INFINITY);
    if joint.joint_type != JointType::Continuous && !is_bounded {
        let at = limit.unwrap_or(node).range().start;
        notices.warning(xml.source, at, format!("joint `{name}` has no position limits: taken as unlimited"));
    } else if kind != JointKind::Continuous {
        for side in ["lower", "upper"] {
            if !has(side) {
                let fault = xml.fault(limit.unwrap_or(node), format!("joint `{name}` has no {side} limit"));
                let help = "URDF would read an omitted limit as 0; a joint without limits is of type continuous";
                let expected =
                    format!("<limit {side}=\"...\"> in {}", if kind == JointKind::Prismatic { "m" } else { "rad" });
                return Err(fault.expected(expected).help(help).invalid());
            }
        }
        (lower, upper) = (unlimited(joint.limit.lower), unlimited(joint.limit.upper));
        if lower > upper {
            let fault = xml.fault(limit.unwrap_or(node), format!("joint `{name}`: the lower limit is above the upper"));
            return Err(fault.found(format!("{lower} > {upper}")).expected("lower <= upper").invalid());
        }
    } else if is_bounded {
        let at = limit.unwrap_or(node).range().start;
        notices.info(xml.source, at, format!("lower and upper limit of the continuous joint `{name}` are ignored"));
    }
    let at = limit.unwrap_or(node).range().start;
    let mut bound = |attribute: &str, value: f64| {
        if has(attribute) {
            if value == 0.0 {
                notices.warning(xml.source, at, format!("joint `{name}`: {attribute} limit 0 lets no drive act"));
            }
            return unlimited(value);
        }
        notices.info(xml.source, at, format!("joint `{name}` has no {attribute} limit: taken as unlimited"));
        f64::INFINITY
    };
    let effort_limit = bound("effort", joint.limit.effort);
    let velocity_limit = bound("velocity", joint.limit.velocity);
    let dynamics = joint.dynamics.clone().unwrap_or_default();
    Ok(Joint {
        name: name.clone(),
        kind,
        lower,
        upper,
        velocity_limit,
        effort_limit,
        damping: dynamics.damping,
        friction: dynamics.friction,
        static_friction: 0.0,
        stribeck_velocity: STRIBECK_SPEED,
        slip_velocity: SLIP_SPEED,
        stop: None,
        armature: 0.0,
        lag: 0.0,
        drive: Drive::default(),
        drive_configured: false,
    })
}

/// The joint's unit axis in its own frame. URDF's default is x.
pub(super) fn axis(xml: &Xml, joint: &urdf_rs::Joint, notices: &mut Notices) -> Result<Vector3<f64>, RobotError> {
    let name = &joint.name;
    let node = xml.named("joint", name);
    let Some(element) = child(node, "axis") else {
        notices.info(xml.source, node.range().start, format!("joint `{name}` has no <axis>: 1 0 0 is used"));
        return Ok(Vector3::x());
    };
    let axis = Vector3::from(joint.axis.xyz.0);
    let length = axis.norm();
    if length < 1e-6 {
        let fault = xml.attribute_fault(element, "xyz", format!("joint `{name}` has an axis of length 0"));
        return Err(fault.expected("a direction, such as 0 0 1").invalid());
    }
    // Deviations beyond the rounding of printed digits are reported.
    if (length - 1.0).abs() > 1e-3 {
        let message = format!("axis of joint `{name}` has length {length:.6}: normalised");
        notices.info(xml.source, element.range().start, message);
    }
    Ok(axis / length)
}
