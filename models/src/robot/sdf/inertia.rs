//! Inertia of links, checked.

use nalgebra::{Matrix3, Vector3};

use super::convert;
use crate::robot::inertia_repair::nearest_physical;
use crate::robot::model::{Base, Joint, Link};
use crate::robot::movable_links::without_inertia;
use crate::robot::notices::Notices;
use crate::robot::rigid_inertia::{Flaw, RigidInertia, examine, moments_text};
use crate::robot::robot_error::RobotError;
use crate::robot::urdf::InertiaPolicy;
use crate::sdf::{At, ResolvedLink, SdfError};

/// A link's inertia in its own frame. A link without `<inertial>` has 1 kg and 1 kg m^2 about each
/// axis, as the format defines; one that `is_fixed` needs none.
pub(super) fn link_inertia(
    link: &ResolvedLink,
    is_fixed: bool,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<RigidInertia, RobotError> {
    let Some((pose, inertial)) = link.inertial else {
        if is_fixed {
            return Ok(RigidInertia { mass: 0.0, com: Vector3::zeros(), tensor: Matrix3::zeros() });
        }
        let message = format!("link `{}` has no <inertial>: the format gives it 1 kg and 1 kg m^2", link.name);
        notices.warning(&link.link.at.source, link.link.at.span.start, message);
        return Ok(RigidInertia { mass: 1.0, com: Vector3::zeros(), tensor: Matrix3::identity() });
    };
    let mut tensor = inertial.tensor;
    let (moments, flaw) = examine(&tensor);
    match flaw {
        Some(Flaw::Negative | Flaw::Triangle) if policy == InertiaPolicy::Repair => {
            tensor = nearest_physical(&tensor);
            let after = moments_text(examine(&tensor).0);
            let message = format!("inertia of link `{}` repaired: {} become {after}", link.name, moments_text(moments));
            notices.warning(&inertial.at.source, inertial.at.span.start, message);
        }
        Some(flaw @ (Flaw::Negative | Flaw::Triangle)) => {
            let (message, expected) = match flaw {
                Flaw::Triangle => {
                    ("breaks the triangle inequality", "the largest principal moment at most the sum of the others")
                }
                _ => ("is not positive definite", "three moments above 0"),
            };
            let error = SdfError::new(inertial.at.clone(), format!("the inertia of link `{}` {message}", link.name));
            let error = error.element(format!("link `{}`", link.name)).found(moments_text(moments)).expected(expected);
            let help = "inertia = \"repair\" in a scenario's [robot] or in the robot file takes the nearest \
                        physical tensor";
            return Err(convert(error.help(help)));
        }
        Some(Flaw::Singular) | None => {}
    }
    let body = RigidInertia { mass: inertial.mass, com: Vector3::zeros(), tensor };
    Ok(body.transformed(&pose.isometry))
}

/// Refuses links that a force would accelerate without limit. `positions` has the element of each.
pub(super) fn check_movable(links: &[Link], joints: &[Joint], base: Base, positions: &[At]) -> Result<(), RobotError> {
    let Some(&i) = without_inertia(links, joints, base).last() else { return Ok(()) };
    let name = &links[i].name;
    let error = SdfError::new(positions[i].clone(), format!("link `{name}` moves without inertia"));
    Err(convert(error.element(format!("link `{name}`")).expected("a mass, and inertia about its joint")))
}
