//! Chooses the link that is the simulated root, and whether it is fixed.

use nalgebra::Isometry3;
use urdf_rs::JointType;

use super::shapes::isometry;
use super::tree::Tree;
use super::xml::{Xml, child};
use crate::robot::error::RobotError;
use crate::robot::model::Base;
use crate::robot::notices::Notices;

/// The simulated root.
pub(super) struct Root {
    /// Index of the link in the URDF.
    pub link: usize,
    /// How it is held.
    pub base: Base,
}

/// A root named `world` without mass is the world itself: what is welded or jointed to it is fixed, what hangs
/// on a floating joint is free. So is what hangs on the only joint of any massless root if that joint floats. Any other
/// root is free unless `requested` says otherwise.
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
            notices.warning(xml.source, node.range().start, "root link `world` has a mass: taken as an ordinary link");
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
