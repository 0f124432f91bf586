//! Chooses the link that is the simulated root, and whether it is fixed.

use nalgebra::Isometry3;
use urdf_rs::JointType;

use super::shapes::isometry;
use super::tree::Tree;
use super::xml::{Xml, child};
use crate::robot::model::Base;
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;

/// The simulated root.
pub(super) struct Root {
    /// Index of the link in the URDF.
    pub link: usize,
    /// How it is held.
    pub base: Base,
}

/// A massless root link is the world itself if its name is `world` or its only joint floats. The
/// child of a floating only joint becomes the free root; otherwise the world is the fixed root. Any
/// other root link is free. `requested` overrides this where possible.
pub(super) fn choose(
    tree: &Tree,
    xml: &Xml,
    requested: Option<Base>,
    notices: &mut Notices,
) -> Result<Root, RobotError> {
    let root = tree.root;
    let link = &tree.robot.links[root];
    let node = xml.named("link", &link.name);
    let joints = &tree.joints_of[root];
    let is_massless = child(node, "inertial").is_none();
    let floats = matches!(joints[..], [j] if tree.robot.joints[j].joint_type == JointType::Floating);
    let is_world = is_massless && (link.name == "world" || floats);
    if !is_world {
        if link.name == "world" {
            notices.warning(
                xml.source,
                node.range().start,
                "root link `world` has a mass: treated as an ordinary link",
            );
        }
        return Ok(Root { link: root, base: requested.unwrap_or(Base::Floating) });
    }
    let single = match joints[..] {
        [j] => Some((j, tree.robot.joints[j].joint_type.clone())),
        _ => None,
    };
    match (single, requested) {
        (Some((j, JointType::Floating)), _) | (Some((j, JointType::Fixed)), Some(Base::Floating)) => {
            let joint = &tree.robot.joints[j];
            if isometry(&joint.origin) != Isometry3::identity() {
                let at = xml.named("joint", &joint.name).range().start;
                let message =
                    format!("origin of joint `{}` is ignored: the scenario sets the pose of the base", joint.name);
                notices.warning(xml.source, at, message);
            }
            Ok(Root { link: tree.child_of[j], base: requested.unwrap_or(Base::Floating) })
        }
        (_, Some(Base::Floating)) => {
            let fault = xml.fault(node, "base = \"floating\" does not fit a root link `world` with moving joints");
            Err(fault.expected("one child on a fixed or floating joint").invalid())
        }
        _ => Ok(Root { link: root, base: Base::Fixed }),
    }
}
