//! The tree of URDF links becomes the tree of moving links: fixed joints welded, every axis turned to z.

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use super::inertia::{Flaw, RigidInertia, examine, moments_text};
use super::root::Root;
use super::shapes::{Shapes, isometry};
use super::tree::Tree;
use super::xml::{Xml, child};
use super::{Loaded, limits};
use crate::robot::error::{Fault, RobotError};
use crate::robot::model::{Base, Joint, Link, LinkId, Merged, Model};
use crate::robot::notice::Notices;

/// The next URDF link to place: welded to a link that is already there, or moved by a joint.
enum Step {
    Weld { link: usize, carrier: usize, frame: Isometry3<f64> },
    Move { joint: usize, carrier: usize, frame: Isometry3<f64> },
}

/// Builds the model. Links come in depth-first order, siblings as their joints stand in the file.
pub(super) fn build(tree: &Tree, xml: &Xml, root: Root, notices: &mut Notices) -> Result<Loaded, RobotError> {
    let mut shapes = Shapes::new(xml, &tree.robot.materials);
    let mut links: Vec<Link> = vec![bare_link(&tree.robot.links[root.link].name, None)];
    let mut joints: Vec<Joint> = Vec::new();
    let mut flawed: Vec<FlawedPart> = Vec::new();
    let mut stack = vec![Step::Weld { link: root.link, carrier: 0, frame: Isometry3::identity() }];
    while let Some(step) = stack.pop() {
        let (index, carrier, frame) = match step {
            Step::Weld { link, carrier, frame } => (link, carrier, frame),
            Step::Move { joint, carrier, frame } => {
                let urdf_joint = &tree.robot.joints[joint];
                let child = tree.child_of[joint];
                // Internal frame of the child, seen from its URDF frame: same origin, z along the axis.
                let turn = z_to(&limits::axis(xml, urdf_joint, notices)?);
                let at_zero = frame * turn;
                joints.push(limits::joint(xml, urdf_joint, notices)?);
                let mut link = bare_link(&tree.robot.links[child].name, Some(LinkId(carrier)));
                link.rotation = at_zero.rotation.to_rotation_matrix().into_inner();
                link.offset = at_zero.translation.vector;
                link.urdf_frame = Isometry3::from_parts(Translation3::identity(), turn.inverse());
                links.push(link);
                (child, links.len() - 1, links[links.len() - 1].urdf_frame)
            }
        };
        let urdf_link = &tree.robot.links[index];
        let here = &mut links[carrier];
        if here.name != urdf_link.name {
            here.merged.push(Merged { name: urdf_link.name.clone(), pose: frame });
        }
        let mut note = |fault| flawed.push(FlawedPart { carrier, fault });
        if let Some(own) = link_inertia(xml, urdf_link, &mut note) {
            let sum = RigidInertia { mass: here.mass, com: here.com, tensor: here.inertia }.plus(&own.moved(&frame));
            (here.mass, here.com, here.inertia) = (sum.mass, sum.com, sum.tensor);
        }
        here.visuals.extend(shapes.visuals(urdf_link, &frame, notices));
        here.collisions.extend(shapes.collisions(urdf_link, &frame, notices));
        // Reversed, since the stack hands the last one out first.
        for &joint in tree.joints_of[index].iter().rev() {
            let origin = frame * isometry(&tree.robot.joints[joint].origin);
            stack.push(match tree.robot.joints[joint].joint_type {
                JointType::Fixed => Step::Weld { link: tree.child_of[joint], carrier, frame: origin },
                _ => Step::Move { joint, carrier, frame: origin },
            });
        }
    }
    judge(xml, &links, root.base, flawed, notices)?;
    let home = vec![0.0; joints.len()];
    let name = tree.robot.name.clone();
    let model = Model { name, base: root.base, links, joints, soles: Vec::new(), end_effectors: Vec::new(), home };
    Ok(Loaded { model, meshes: shapes.files })
}

/// The rotation that takes z to a unit axis. Axes along x, y or z get exact quaternions, so that a robot drawn with
/// them has rotation matrices of zeros and ones.
fn z_to(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let exact = |w: f64, x: f64, y: f64, z: f64| UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
    match (axis.x, axis.y, axis.z) {
        (0.0, 0.0, z) if z > 0.0 => UnitQuaternion::identity(),
        (0.0, 0.0, _) => exact(0.0, 1.0, 0.0, 0.0),
        (x, 0.0, 0.0) if x > 0.0 => exact(0.5, 0.5, 0.5, 0.5),
        (_, 0.0, 0.0) => exact(0.5, 0.5, -0.5, -0.5),
        (0.0, y, 0.0) if y > 0.0 => exact(0.5, -0.5, -0.5, -0.5),
        (0.0, _, 0.0) => exact(0.5, 0.5, 0.5, -0.5),
        // The half-way quaternion (1 + z . a, z x a) is ill-conditioned near -z: start from there by a half turn about x.
        (x, y, z) if z < 0.0 => shortest(-y, x, z) * exact(0.0, 1.0, 0.0, 0.0),
        (x, y, z) => shortest(-y, x, z),
    }
}

/// The shortest rotation to (.., .., z) from z (or from -z when `z` is negative); `cx`, `cy` are those of z x axis.
fn shortest(cx: f64, cy: f64, z: f64) -> UnitQuaternion<f64> {
    let sign = z.signum();
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(1.0 + z.abs(), sign * cx, sign * cy, 0.0))
}

fn bare_link(name: &str, parent: Option<LinkId>) -> Link {
    Link {
        name: name.to_owned(),
        parent,
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass: 0.0,
        com: Vector3::zeros(),
        inertia: Matrix3::zeros(),
        urdf_frame: Isometry3::identity(),
        merged: Vec::new(),
        visuals: Vec::new(),
        collisions: Vec::new(),
    }
}

/// A part whose inertia no body can have: an error if the rigid body it ends up in has none either, else a warning, for
/// exporters put placeholders on massless frames.
struct FlawedPart {
    carrier: usize,
    fault: Fault,
}

/// A link's own inertia in its URDF frame; `None` when it has none. What is odd about it goes to `flawed`.
fn link_inertia(xml: &Xml, link: &urdf_rs::Link, flawed: &mut impl FnMut(Fault)) -> Option<RigidInertia> {
    let inertial = child(xml.named("link", &link.name), "inertial")?;
    let i = &link.inertial.inertia;
    let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let mass = link.inertial.mass.value;
    let name = &link.name;
    if mass == 0.0 {
        if tensor != Matrix3::zeros() {
            let at = child(inertial, "mass").unwrap_or(inertial);
            let fault = xml.attribute_fault(at, "value", format!("link `{name}` has inertia but no mass"));
            flawed(fault.wanted("a mass above 0"));
        }
        return None;
    }
    let at = child(inertial, "inertia").unwrap_or(inertial);
    let (moments, flaw) = examine(&tensor);
    let (words, wanted) = match flaw {
        Some(Flaw::Negative | Flaw::Singular) => ("is not positive definite", "three moments above 0"),
        Some(Flaw::Triangle) => {
            ("breaks the triangle inequality", "the largest principal moment at most the sum of the others")
        }
        None => ("", ""),
    };
    if flaw.is_some() {
        let fault = xml.fault(at, format!("the inertia of link `{name}` {words}"));
        flawed(fault.seen(moments_text(moments)).wanted(wanted));
    }
    let body = RigidInertia { mass, com: Vector3::zeros(), tensor };
    Some(body.moved(&isometry(&link.inertial.origin)))
}

/// Every link that can accelerate needs mass and a tensor a body can have, welded parts counted.
fn judge(
    xml: &Xml,
    links: &[Link],
    base: Base,
    flawed: Vec<FlawedPart>,
    notices: &mut Notices,
) -> Result<(), RobotError> {
    for (i, link) in links.iter().enumerate().skip(usize::from(base == Base::Fixed)) {
        let (moments, flaw) = examine(&link.inertia);
        let part = flawed.iter().find(|part| part.carrier == i);
        let is_bad = match flaw {
            _ if link.mass == 0.0 => true,
            Some(Flaw::Negative | Flaw::Singular) => true,
            // Sound parts make a sound whole but for rounding.
            Some(Flaw::Triangle) => part.is_some(),
            None => false,
        };
        if !is_bad {
            continue;
        }
        if let Some(part) = part {
            return Err(part.fault.clone().invalid());
        }
        let node = xml.named("link", &link.name);
        if link.mass == 0.0 {
            let message = format!("link `{}` moves but has no mass, nor has anything welded to it", link.name);
            return Err(xml.fault(node, message).wanted("<inertial> with a mass above 0").invalid());
        }
        let fault = xml.fault(node, format!("the inertia of link `{}` is not positive definite", link.name));
        return Err(fault.seen(moments_text(moments)).wanted("three moments above 0").invalid());
    }
    for FlawedPart { fault, .. } in flawed {
        let words = format!(
            "{}{}",
            fault.message,
            if fault.seen.is_empty() { String::new() } else { format!(": {}", fault.seen) }
        );
        notices.warning(xml.source, fault.span.start, words);
    }
    Ok(())
}
