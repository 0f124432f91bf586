//! Change of the owner when only some corners of a patch stay in contact.
//!
//! A patch that opens turns about the corners that stay. The feature that then defines the plane is
//!
//! ```text
//! stays in contact                                owner
//! vertex of the incident body                     the face (as it is)
//! corner of the owner                             the incident face
//! crossing                                        its two edges
//! two corners on an edge of the incident body     the face (as it is)
//! two corners on an edge of the owner             the incident face
//! one corner of parallel edges                    its nearest points
//! ```
//!
//! At a crossing of a rim the face remains: at a flat instant the normal of a rim and an edge in its plane is
//! not defined. For ends of cylinders as owners, all corners of the ring count as one edge.
//!
//! At a flat instant, with the relative angular velocity along n, the change alters neither
//! positions, gaps, velocities nor bias accelerations of the common corners.

use super::cylinder::edge_feature;
use super::parallel;
use super::roles::Roles;
use super::{ConvexBody, Corner, Feature, Owner, Placement, Topology};

/// The new owner; `None` if the present one remains. `clamped`: whether a corner, by its index in
/// the topology, stays in contact.
pub fn reowner(
    topology: &Topology,
    clamped: impl Fn(usize) -> bool,
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
) -> Option<Owner> {
    let mut stay = topology.corners.iter().enumerate().filter(|(c, _)| clamped(*c)).map(|(_, corner)| corner);
    if let Owner::Along(i, j) = topology.owner {
        return match (stay.next(), stay.next()) {
            (Some(corner), None) => Some(parallel::corner_owner((i, j), corner, (a, pa), (b, pb))),
            _ => None,
        };
    }
    let roles = Roles::new(topology.owner, a, pa, b, pb)?;
    let swapped = topology.incident.map(|k| if roles.is_owner_b { Owner::FaceOfA(k) } else { Owner::FaceOfB(k) });
    match (stay.next(), stay.next(), stay.next()) {
        (Some(&Corner::Crossing { a: i, b: j }), None, None) => match (edge_feature(a, i), edge_feature(b, j)) {
            (Feature::Edge(i), Feature::Edge(j)) => Some(Owner::Edges(i, j)),
            _ => None,
        },
        (Some(corner), None, None) => roles.owner_vertex(corner).and(swapped),
        (Some(first), Some(second), None) => {
            let incident = roles.other.face(topology.incident?);
            if roles.owner.barrel.is_some() {
                let on_ring = [first, second].iter().all(|corner| roles.owner_vertex(corner).is_some());
                return swapped.filter(|_| on_ring);
            }
            let stays = |&edge: &u16| is_on_other(&roles, first, edge) && is_on_other(&roles, second, edge);
            let swaps = |&edge: &u16| is_on_owner(&roles, first, edge) && is_on_owner(&roles, second, edge);
            let is_swapped = roles.owner.face(roles.face).edges.iter().any(swaps);
            swapped.filter(|_| is_swapped && !incident.edges.iter().any(stays))
        }
        _ => None,
    }
}

/// Whether a corner lies on an edge of the other body.
fn is_on_other(roles: &Roles, corner: &Corner, edge: u16) -> bool {
    match roles.incident_vertex(corner) {
        Some(k) => roles.other.edge(edge).ends.contains(&k),
        None => roles.crossing(corner).is_some_and(|(_, other)| other == edge),
    }
}

/// Whether a corner lies on an edge of the owner.
fn is_on_owner(roles: &Roles, corner: &Corner, edge: u16) -> bool {
    match roles.owner_vertex(corner) {
        Some(k) => roles.owner.edge(edge).ends.contains(&k),
        None => roles.crossing(corner).is_some_and(|(owner, _)| owner == edge),
    }
}
