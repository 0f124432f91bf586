//! Planes of patches: which feature owns them where several have the same distance, and when only some corners
//! of a patch touch.

use crate::contact::model::state::SoleState;
use crate::patches::{self, Face, Owner, Placement, Topology};
use crate::sim::bodies::{Body, Pair, PairPatch, Part};
use crate::sim::plant::Plant;
use nalgebra::UnitQuaternion;

/// Gap up to which corners of a patch with another plane count as near, m.
pub(super) const NEAR: f64 = 1e-9;

/// Time, s, after which bodies that touch are apart if they move apart.
const SOON: f64 = 1e-6;

/// Gap of a corner, m, of a patch that touches at others and is tilted.
const TILTED: f64 = 1e-6;

/// Distance, m, up to which corners near a border are one point.
const POINT: f64 = 1e-6;

/// The corners of a part on the plane of those that stay in contact, by their index. `None` if they keep their plane,
/// or if the new one does not separate the bodies: where a vertex and a crossing are one point, a state may hold
/// either. `near`: greatest gap of a corner, m.
pub(super) fn of_corners(part: &Part, plant: &Plant, stays: impl Fn(usize) -> bool, near: f64) -> Option<Topology> {
    let (a, b) = bodies(plant, &part.pair);
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    let (pa, pb) = (a.placement(mechanisms), b.placement(mechanisms));
    let owner = patches::reowner(&part.topology, stays, &a.shape, &pa, &b.shape, &pb)?;
    if owner == part.topology.owner {
        return None;
    }
    // The side of crossing edges is that of the present normal.
    let mut topology = part.topology.clone();
    let is_patch = patches::topology(&a.shape, &pa, &b.shape, &pb, near, owner, None, &mut topology);
    (is_patch && topology.separates(patches::SEPARATES)).then_some(topology)
}

/// Whether a part whose state is free is about to touch along another feature than that of its plane, to which it is
/// tilted: the motion of its corners is then not that of the gaps.
pub(super) fn is_other_plane(plant: &Plant, part: &Part, owner: Owner) -> bool {
    let tilted = |patch: &PairPatch| (0..patch.len()).any(|i| patch.point(i).gap > TILTED);
    let first = plant.polygons.len() - plant.pair_patches().count();
    let mut patches = plant.pair_patches().enumerate();
    let own = patches.find(|(_, patch)| patch.parts.iter().any(|other| other.pair.bodies == part.pair.bodies));
    owner != part.topology.owner
        && own.is_some_and(|(p, patch)| plant.states[first + p] == SoleState::FREE && tilted(patch))
}

/// The part on the plane of the corners that touch at an event: several features may have the same distance, and
/// an impact acts along the normal of those that touch.
pub(super) fn on_touching_features(part: Part, plant: &Plant, reach: f64) -> Part {
    // A flat patch keeps its plane.
    if (0..part.topology.corners.len()).all(|c| part.touches(c, TILTED)) {
        return part;
    }
    match of_corners(&part, plant, |c| part.touches(c, NEAR), reach) {
        Some(topology) => {
            let mechanisms = plant.objects.mechanisms(&plant.ws);
            Part::new(part.pair.clone(), topology, &plant.bodies, mechanisms)
        }
        None => part,
    }
}

/// The part on the feature along which the bodies move apart, if they do so at a point where several features
/// meet. A vertex that slides over a border touches the face and the border: the distance is then that from the
/// plane which it leaves faster.
pub(super) fn opened(part: &Part, plant: &Plant, reach: f64) -> Option<Part> {
    if !part.touches_at_point(NEAR, POINT) {
        return None;
    }
    let (a, b) = bodies(plant, &part.pair);
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    let (pa, pb) = (a.placement(mechanisms), b.placement(mechanisms));
    let (after_a, after_b) = (ahead(&pa, SOON), ahead(&pb, SOON));
    let after = patches::separation(&a.shape, &after_a, &b.shape, &after_b, None, f64::INFINITY);
    let owner = after.owner.filter(|owner| *owner != part.topology.owner)?;
    if part.opening_speed(NEAR) > plant.rest || after.distance <= NEAR + plant.rest * SOON {
        return None;
    }
    let mut topology = part.topology.clone();
    if !patches::topology(&a.shape, &pa, &b.shape, &pb, reach, owner, None, &mut topology) {
        return None;
    }
    let mut other = Part::new(part.pair.clone(), topology, &plant.bodies, mechanisms);
    other.opens = true;
    Some(other).filter(|other| other.opening_speed(NEAR) > plant.rest)
}

/// The face of body B that lies in the plane of a present patch of body A with another piece of the world, if one
/// does.
pub(super) fn coplanar_face(plant: &Plant, pair: &Pair, b: &Body, pb: &Placement) -> Option<Owner> {
    if pair.links.1.is_some() {
        return None;
    }
    let parts = plant.pair_patches().flat_map(|patch| &patch.parts);
    let is_neighbour = |part: &&Part| part.pair.bodies.0 == pair.bodies.0 && part.pair.bodies.1 != pair.bodies.1;
    let mut planes = parts.filter(is_neighbour).filter_map(Part::world_plane);
    planes.find_map(|(n, p)| {
        let is_coplanar = |face: &Face| {
            let m = pb.rotation * face.normal;
            face.touchable && (m - n).norm() < NEAR && (m.dot(&(p - pb.position)) - face.offset).abs() < NEAR
        };
        b.shape.faces.iter().position(is_coplanar).map(|k| Owner::FaceOfB(k as u16))
    })
}

pub(super) fn bodies<'a>(plant: &'a Plant, pair: &Pair) -> (&'a Body, &'a Body) {
    (&plant.bodies[pair.bodies.0], &plant.bodies[pair.bodies.1])
}

/// The placement after a time `dt`, s, at its present velocity.
pub(super) fn ahead(placement: &Placement, dt: f64) -> Placement {
    let turn = UnitQuaternion::from_scaled_axis(placement.omega * dt).to_rotation_matrix();
    Placement {
        rotation: turn.matrix() * placement.rotation,
        position: placement.position + placement.velocity * dt,
        ..*placement
    }
}
