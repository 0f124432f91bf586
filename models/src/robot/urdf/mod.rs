//! Reads a URDF to the tree of moving links.
//!
//! `urdf-rs` reads the values. It accepts vectors with commas, unknown parents, and missing
//! inertias and limits, and it reports no positions. [`grammar`] therefore checks the XML first and
//! refuses files whose meaning `urdf-rs` would change silently.
//!
//! Called by the loader of robots.

mod compound_joints;
mod grammar;
mod inertia;
mod joint_limits;
mod moving_tree;
mod root;
mod sanitized_text;
mod shapes;
mod tree;
mod xml;

use std::path::PathBuf;

pub(super) use joint_limits::Mimic;

use super::model::{Base, Model};
use super::notices::Notices;
use super::robot_error::{FileError, RobotError};
use super::xml_syntax;
use crate::text::source::Source;

/// The robot as the URDF describes it.
pub(super) struct Loaded {
    /// The model, without soles, drives and home posture.
    pub model: Model,
    /// Mesh files read, with their bytes.
    pub meshes: Vec<(PathBuf, Vec<u8>)>,
    /// Joints that follow others.
    pub mimics: Vec<Mimic>,
}

/// Treatment of an inertia that no body can have.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum InertiaPolicy {
    /// The robot is refused with the name of the link.
    #[default]
    Refuse,
    /// The nearest physical tensor replaces it, with a notice.
    Repair,
}

/// Reads a URDF. `base`, if given, decides how the root is held.
pub(super) fn load(
    source: &Source,
    base: Option<Base>,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Loaded, RobotError> {
    let document = xml_syntax::parse(source)?;
    let xml = xml::Xml::new(source, &document)?;
    grammar::check(&xml, notices)?;
    let mut mimics = Vec::new();
    for joint in xml.robot.children().filter(|n| n.has_tag_name("joint")) {
        joint_limits::check_type(&xml, joint)?;
        mimics.extend(joint_limits::mimic(&xml, joint, notices));
    }
    let robot = urdf_rs::read_from_string(&sanitized_text::sanitize(&xml)).map_err(|e| {
        FileError::new(source, document.root_element().range(), format!("the URDF cannot be read: {e}")).invalid()
    })?;
    check_agreement(&robot, &xml)?;
    joint_limits::remove_invalid_mimics(&mut mimics, &xml, notices);
    let tree = tree::Tree::new(&robot, &xml)?;
    let root = root::choose(&tree, &xml, base, notices)?;
    Ok(Loaded { mimics, ..moving_tree::build(&tree, &xml, root, policy, notices)? })
}

/// Both readers must find the same links and joints, since one gives the values and the other the
/// positions.
fn check_agreement(robot: &urdf_rs::Robot, xml: &xml::Xml) -> Result<(), RobotError> {
    let names = |tag| xml.robot.children().filter(move |n| n.has_tag_name(tag)).filter_map(|n| n.attribute("name"));
    let links = robot.links.iter().map(|l| l.name.as_str());
    let joints = robot.joints.iter().map(|j| j.name.as_str());
    if names("link").eq(links) && names("joint").eq(joints) {
        return Ok(());
    }
    Err(xml.fault(xml.robot, "the URDF cannot be read: the two readers find different names").invalid())
}
