//! Builds the tree of moving links from the URDF's: fixed joints are welded, and each joint axis
//! becomes z.

use nalgebra::{Isometry3, Translation3, Vector3};
use urdf_rs::JointType;

use super::inertia::{FlawedPart, check_inertias, link_inertia};
use super::root::Root;
use super::shapes::{Shapes, isometry};
use super::tree::Tree;
use super::xml::Xml;
use super::{InertiaPolicy, Loaded, compound_joints, joint_limits};
use crate::robot::model::{Joint, Link, LinkId, Merged, Model};
use crate::robot::movable_links::without_inertia;
use crate::robot::moving_links::{MAX_JOINTS, bare_link, free_joint, z_to};
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;

/// The next URDF link: welded to a link of the tree, or moved by a joint.
enum Step {
    Weld { link: usize, carrier: usize, frame: Isometry3<f64> },
    Move { joint: usize, carrier: usize, frame: Isometry3<f64> },
}

/// Builds the model. Links come in depth-first order, siblings in the order of their joints in the
/// file. With [`InertiaPolicy::Repair`], joints that nothing resists are locked.
pub(super) fn build(
    tree: &Tree,
    xml: &Xml,
    root: Root,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Loaded, RobotError> {
    let mut shapes = Shapes::new(xml, &tree.robot.materials);
    let mut parts = walk(tree, xml, &root, policy, &[], &mut shapes, notices)?;
    if policy == InertiaPolicy::Repair {
        let bare = without_inertia(&parts.links, &parts.joints, root.base);
        let mut locked: Vec<usize> = bare.iter().filter(|&&i| i > 0).map(|&i| parts.moved_by[i - 1]).collect();
        locked.dedup();
        for joint in locked.iter().map(|&j| &tree.robot.joints[j]) {
            let message = format!("joint `{}` is locked at 0: nothing it moves has inertia about it", joint.name);
            notices.warning(xml.source, xml.named("joint", &joint.name).range().start, message);
        }
        if !locked.is_empty() {
            parts = walk(tree, xml, &root, policy, &locked, &mut shapes, notices)?;
        }
    }
    check_count(tree, xml, &parts)?;
    check_inertias(xml, &parts, root.base, notices)?;
    let model = Model::tree(tree.robot.name.clone(), root.base, parts.links, parts.joints);
    Ok(Loaded { model, meshes: shapes.meshes.files, mimics: Vec::new() })
}

/// Refuses a robot with too many moving joints.
fn check_count(tree: &Tree, xml: &Xml, parts: &Parts) -> Result<(), RobotError> {
    let Some(&joint) = parts.moved_by.get(MAX_JOINTS) else { return Ok(()) };
    let name = &tree.robot.joints[joint].name;
    let fault = xml.fault(xml.named("joint", name), "the robot has too many moving joints");
    Err(fault.found(parts.joints.len()).expected(format!("at most {MAX_JOINTS}")).invalid())
}

/// The moving tree before its inertias are checked.
pub(super) struct Parts {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// For each of `joints`, the URDF joint that it is or belongs to.
    moved_by: Vec<usize>,
    /// Flaws of the inertias of single URDF links.
    pub flawed: Vec<FlawedPart>,
}

/// Walks the tree; URDF joints in `locked` are welded.
fn walk(
    tree: &Tree,
    xml: &Xml,
    root: &Root,
    policy: InertiaPolicy,
    locked: &[usize],
    shapes: &mut Shapes,
    notices: &mut Notices,
) -> Result<Parts, RobotError> {
    let mut links: Vec<Link> = vec![bare_link(&tree.robot.links[root.link].name, None)];
    let mut joints: Vec<Joint> = Vec::new();
    let mut moved_by: Vec<usize> = Vec::new();
    let mut flawed: Vec<FlawedPart> = Vec::new();
    let mut stack = vec![Step::Weld { link: root.link, carrier: 0, frame: Isometry3::identity() }];
    while let Some(step) = stack.pop() {
        let (index, carrier, frame) = match step {
            Step::Weld { link, carrier, frame } => (link, carrier, frame),
            Step::Move { joint, carrier, frame } => {
                let urdf_joint = &tree.robot.joints[joint];
                let child = tree.child_of[joint];
                let child_name = &tree.robot.links[child].name;
                let (mut carrier, mut frame) = (carrier, frame);
                for (moved, motion, axis) in motions(xml, urdf_joint, child_name, notices)? {
                    // Internal frame of the moved link, seen from its URDF frame: same origin, z
                    // along the axis.
                    let turn = z_to(&axis);
                    let at_zero = frame * turn;
                    let mut link = bare_link(&moved, Some(LinkId(carrier)));
                    link.rotation = at_zero.rotation.to_rotation_matrix().into_inner();
                    link.offset = at_zero.translation.vector;
                    link.urdf_frame = Isometry3::from_parts(Translation3::identity(), turn.inverse());
                    (carrier, frame) = (links.len(), link.urdf_frame);
                    links.push(link);
                    joints.push(motion);
                    moved_by.push(joint);
                }
                (child, carrier, frame)
            }
        };
        let urdf_link = &tree.robot.links[index];
        let carrying = &mut links[carrier];
        if carrying.name != urdf_link.name {
            carrying.merged.push(Merged { name: urdf_link.name.clone(), pose: frame });
        }
        let mut note = |flaw, fault| flawed.push(FlawedPart { carrier, flaw, fault });
        if let Some(own) = link_inertia(xml, urdf_link, policy, &mut note, notices) {
            carrying.set_body(&carrying.body().plus(&own.transformed(&frame)));
        }
        carrying.visuals.extend(shapes.visuals(urdf_link, &frame, notices));
        carrying.collisions.extend(shapes.collisions(urdf_link, &frame, notices));
        // Reversed, since the stack returns the last one first.
        for &joint in tree.joints_of[index].iter().rev() {
            let origin = frame * isometry(&tree.robot.joints[joint].origin);
            stack.push(match tree.robot.joints[joint].joint_type {
                _ if locked.contains(&joint) => Step::Weld { link: tree.child_of[joint], carrier, frame: origin },
                JointType::Fixed => Step::Weld { link: tree.child_of[joint], carrier, frame: origin },
                _ => Step::Move { joint, carrier, frame: origin },
            });
        }
    }
    Ok(Parts { links, joints, moved_by, flawed })
}

/// The motions of one joint, parent's side first: name of the moved link, joint, unit axis in the
/// joint's frame.
fn motions(
    xml: &Xml,
    joint: &urdf_rs::Joint,
    child: &str,
    notices: &mut Notices,
) -> Result<Vec<(String, Joint, Vector3<f64>)>, RobotError> {
    let axis = match joint.joint_type {
        JointType::Floating => Vector3::z(),
        _ => joint_limits::axis(xml, joint, notices)?,
    };
    let Some(parts) = compound_joints::parts(&joint.joint_type, &axis) else {
        return Ok(vec![(child.to_owned(), joint_limits::joint(xml, joint, notices)?, axis)]);
    };
    let names: Vec<String> = parts.iter().map(|p| format!("`{}/{}`", joint.name, p.suffix)).collect();
    let steep = if parts.len() == 6 { "; it must not pitch by 90 degrees" } else { "" };
    let message = format!(
        "joint `{}` is modelled as the chain of {}, passive and unlimited{steep}",
        joint.name,
        names.join(", ")
    );
    notices.warning(xml.source, xml.named("joint", &joint.name).range().start, message);
    let last = parts.len() - 1;
    let chain = parts.into_iter().enumerate().map(|(i, part)| {
        let name = format!("{}/{}", joint.name, part.suffix);
        let moved = if i == last { child.to_owned() } else { name.clone() };
        (moved, free_joint(name, part.kind), part.axis)
    });
    Ok(chain.collect())
}
