//! Checks that links have physical inertias and can be accelerated. Unphysical links are refused by
//! name, or repaired on request.

use nalgebra::{Matrix3, Vector3};

use crate::robot::inertia_repair::nearest_physical;
use crate::robot::model::{Base, Link};
use crate::robot::movable_links::without_inertia;
use crate::robot::notices::Notices;
use crate::robot::rigid_inertia::{Flaw, RigidInertia, examine, moments_text};
use crate::robot::robot_error::{FileError, RobotError};
use crate::robot::urdf::InertiaPolicy;
use crate::robot::urdf::moving_tree::Parts;
use crate::robot::urdf::shapes::isometry;
use crate::robot::urdf::xml::{Xml, child};

/// A URDF link whose inertia no body can have, or that is a point or a rod. It is an error if the
/// rigid body of which it is part is flawed too, otherwise a warning: exporters write placeholders
/// for massless frames.
pub(in crate::robot::urdf) struct FlawedPart {
    /// The moving link of which it is part.
    pub carrier: usize,
    pub flaw: Flaw,
    pub fault: FileError,
}

/// A link's own inertia in its URDF frame; `None` when it has none. A flaw goes to `flawed`, unless
/// it is repaired.
pub(in crate::robot::urdf) fn link_inertia(
    xml: &Xml,
    link: &urdf_rs::Link,
    policy: InertiaPolicy,
    flawed: &mut impl FnMut(Flaw, FileError),
    notices: &mut Notices,
) -> Option<RigidInertia> {
    let inertial = child(xml.named("link", &link.name), "inertial")?;
    let i = &link.inertial.inertia;
    let mut tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let mass = link.inertial.mass.value;
    let name = &link.name;
    if mass == 0.0 {
        if tensor == Matrix3::zeros() {
            return None;
        }
        let (moments, flaw) = examine(&tensor);
        let counts = !matches!(flaw, Some(Flaw::Negative | Flaw::Triangle));
        let remark = if counts { "which count" } else { "which no body can have and which are left out" };
        let at = child(inertial, "mass").unwrap_or(inertial);
        let fault = xml.attribute_fault(at, "value", format!("link `{name}` has inertia but no mass"));
        flawed(Flaw::Singular, fault.found(format!("{}, {remark}", moments_text(moments))).expected("a mass above 0"));
        // The position of its centre has no effect.
        let body = RigidInertia { mass, com: Vector3::zeros(), tensor };
        return counts.then(|| body.transformed(&isometry(&link.inertial.origin)));
    }
    let at = child(inertial, "inertia").unwrap_or(inertial);
    let (moments, flaw) = examine(&tensor);
    // A point mass is a body; `check_inertias` checks whether it can be moved.
    let is_repaired = policy == InertiaPolicy::Repair && tensor != Matrix3::zeros();
    match flaw {
        Some(_) if is_repaired => {
            tensor = nearest_physical(&tensor);
            let after = moments_text(examine(&tensor).0);
            let message = format!("inertia of link `{name}` repaired: {} become {after}", moments_text(moments));
            notices.warning(xml.source, at.range().start, message);
        }
        Some(flaw) => {
            let (message, expected) = match flaw {
                Flaw::Negative | Flaw::Singular => ("is not positive definite", "three moments above 0"),
                Flaw::Triangle => {
                    ("breaks the triangle inequality", "the largest principal moment at most the sum of the others")
                }
            };
            let fault = xml.fault(at, format!("the inertia of link `{name}` {message}"));
            flawed(flaw, fault.found(moments_text(moments)).expected(expected).help(HOW_TO_REPAIR));
        }
        None => {}
    }
    let body = RigidInertia { mass, com: Vector3::zeros(), tensor };
    Some(body.transformed(&isometry(&link.inertial.origin)))
}

const HOW_TO_REPAIR: &str = "inertia = \"repair\" in a scenario's [robot] or in the robot file, or inspect's --repair, \
     takes the nearest physical tensor and locks joints that nothing resists";

/// Checks that every link that can accelerate has, with its welded parts, a tensor that a body can
/// have, and inertia along its joint.
pub(in crate::robot::urdf) fn check_inertias(
    xml: &Xml,
    parts: &Parts,
    base: Base,
    notices: &mut Notices,
) -> Result<(), RobotError> {
    let Parts { links, joints, flawed, .. } = parts;
    let unphysical = |i: usize, link: &Link| match examine(&link.inertia).1 {
        Some(Flaw::Negative) => true,
        // The union of valid parts is valid up to rounding.
        Some(Flaw::Triangle) => flawed.iter().any(|part| part.carrier == i && part.flaw != Flaw::Singular),
        _ => false,
    };
    let moving = links.iter().enumerate().skip(usize::from(base == Base::Fixed));
    if let Some((i, _)) = moving.clone().find(|(i, link)| unphysical(*i, link)) {
        return Err(refusal(xml, links, i, flawed));
    }
    // The deepest one; those above may lack inertia only because of it.
    if let Some(&i) = without_inertia(links, joints, base).last() {
        return Err(refusal(xml, links, i, flawed));
    }
    for (_, link) in moving.filter(|(_, link)| link.mass == 0.0) {
        let node = xml.named("link", &link.name);
        // Links between the motions of one joint are not in the file.
        if node == xml.robot {
            continue;
        }
        let at = node.range().start;
        notices.info(
            xml.source,
            at,
            format!("link `{}` has no mass: its inertia is that of the links it carries", link.name),
        );
    }
    for FlawedPart { fault, .. } in flawed {
        let message = format!(
            "{}{}",
            fault.message,
            if fault.found.is_empty() { String::new() } else { format!(": {}", fault.found) }
        );
        notices.warning(xml.source, fault.span.start, message);
    }
    Ok(())
}

/// Why the link cannot be simulated: the error of a flawed part, if there is one.
fn refusal(xml: &Xml, links: &[Link], i: usize, flawed: &[FlawedPart]) -> RobotError {
    if let Some(part) = flawed.iter().find(|part| part.carrier == i) {
        return part.fault.clone().invalid();
    }
    let link = &links[i];
    let node = xml.named("link", &link.name);
    if link.mass == 0.0 {
        let message = format!("link `{}` moves but has no mass, nor has anything welded to it", link.name);
        let fault = xml.fault(node, message).expected("<inertial> with a mass above 0");
        return fault.help(HOW_TO_REPAIR).invalid();
    }
    let fault = xml.fault(node, format!("the inertia of link `{}` is not positive definite", link.name));
    let fault = fault.found(moments_text(examine(&link.inertia).0)).expected("three moments above 0");
    fault.help(HOW_TO_REPAIR).invalid()
}
