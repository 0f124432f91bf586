//! Owners that are as good as the one that `separation` names.
//!
//! Where a face lies against an edge, its sides that are parallel to each other have the same normal with the edge,
//! and the same support distance. Only those that reach the edge make a patch.

use super::separation::{PARALLEL, REACH, Search};
use super::{
    ConvexBody, Face, Feature, Owner, PatchGeometry, Placement, RESOLUTION, SEPARATES, Topology, geometry, topology,
};

/// Greatest gap, m, of corners of a face that touch at an instant at which its normal is that of a pair of edges.
const FLAT: f64 = 10.0 * RESOLUTION;

/// The patch of a face that touches at two corners or more: of `present`, the owner so far, or of a face at the
/// features of `owner`, if that is no face. An edge that turns about its crossing with a side of a face has come to
/// lie in the face, and crosses another side as well. `near`: as for [`topology`].
pub fn flat_topology(
    [owner, present]: [Owner; 2],
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    near: f64,
) -> Option<Topology> {
    let mut found = Topology::default();
    let mut at = PatchGeometry::default();
    let mut is_flat = |face: Owner| {
        topology(a, pa, b, pb, near, face, None, &mut found) && found.separates(SEPARATES) && {
            geometry(&found, a, pa, b, pb, &mut at);
            let touching = at.points.iter().filter(|point| point.gap <= FLAT).count();
            touching > 1 && at.points.iter().all(|point| point.gap >= -FLAT)
        }
    };
    let remains = owner != present && present.features().is_none() && is_flat(present);
    let mut has_face = |(of_a, of_b)| {
        faces_at(b, of_b).any(|k| is_flat(Owner::FaceOfB(k))) || faces_at(a, of_a).any(|k| is_flat(Owner::FaceOfA(k)))
    };
    (remains || owner.features().is_some_and(&mut has_face)).then_some(found)
}

/// Touchable faces of a body at an edge.
fn faces_at(body: &ConvexBody, feature: Feature) -> impl Iterator<Item = u16> {
    let is_at = move |face: &Face| match feature {
        Feature::Edge(edge) => face.touchable && face.edges.contains(&edge),
        Feature::Vertex(_) | Feature::Rim(_) => false,
    };
    body.faces.iter().enumerate().filter(move |(_, face)| is_at(face)).map(|(k, _)| k as u16)
}

/// The patch of the first owner (faces of B, faces of A, edge pairs) whose support distance is `distance`, m, up to
/// 1e-9 m, and that has corners with gaps of at most `near`, m. Tries all features.
pub fn tied_topology(
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    distance: f64,
    near: f64,
) -> Option<Topology> {
    let search = Search::new(a, pa, b, pb);
    let mut found = Topology::default();
    let mut at = PatchGeometry::default();
    let mut is_patch = |owner: Owner, value: f64| {
        let ties = value >= distance - REACH && search.is_touchable(owner);
        let is_near = ties && topology(a, pa, b, pb, near, owner, None, &mut found);
        // The normal of edges may have the other side, on which they are deep.
        is_near && {
            geometry(&found, a, pa, b, pb, &mut at);
            at.points.iter().all(|point| point.gap >= distance - REACH)
        }
    };
    let of_b = |(k, face): (usize, &Face)| (Owner::FaceOfB(k as u16), search.along(&face.normal));
    let of_a = |(k, face): (usize, &Face)| (Owner::FaceOfA(k as u16), search.along(&-(search.r * face.normal)));
    let has_patch = b.faces.iter().enumerate().map(of_b).any(|(owner, value)| is_patch(owner, value))
        || a.faces.iter().enumerate().map(of_a).any(|(owner, value)| is_patch(owner, value))
        || a.edges.iter().enumerate().any(|(i, edge)| {
            let e = search.r * edge.direction;
            b.edges.iter().enumerate().any(|(j, other)| {
                let n = e.cross(&other.direction);
                let owner = Owner::Edges(i as u16, j as u16);
                let norm = n.norm();
                norm > PARALLEL && {
                    let n = n / norm;
                    is_patch(owner, search.along(&n).max(search.along(&-n)))
                }
            })
        });
    has_patch.then_some(found)
}
