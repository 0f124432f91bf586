//! A continuous function of the configuration that is positive while a topology holds.
//!
//! It is the minimum of functions f_k with offsets. Two convex polygons in a plane change the
//! features of their intersection only when a corner of one crosses the border of the other. So,
//! for owners that are faces, with the inner distance d(x) of a point from a polygon (least over its
//! sides, positive inside), the functions are
//!
//! ```text
//! height of x           vertices x of the other body outside its incident face
//! + d(x) or -d(x)       corners x of the incident face, d of the owner's face
//! + d(w) or -d(w)       corners w of the owner's face, d of the projected incident face
//! - d(x), - d(w)        those on the border: the crossings of their edges appear when they move inside
//! t and L - t           crossings at t on an edge of the owner with the length L
//! ```
//!
//! The sign is + for corners of the topology. Other owners have n and the core points c_A, c_B:
//!
//! ```text
//! n . (x - c_A)         vertices x of A that are not of the owner's feature
//! -n . (y - c_B)        vertices y of B that are not of the owner's feature
//! s, L_A - s            coordinate of c_A on an edge of A, for edge pairs and edge and vertex
//! t, L_B - t            coordinate of c_B on an edge of B
//! 0.9 - |n . a|         times a distance: the axis a from which tangents are built (vertex pairs)
//! n . (c' - c)          rims of A with the centre c: height of the centre c' of the other end
//! R |P n|               rims of A: the plane does not lie on the end (`cylinder`); for points, signed
//! ```
//!
//! Rims of B have the same with -n. Cylinders on faces are in `flat`, parallel edges in `parallel`.
//!
//! A function that is less than `RESOLUTION` when the topology is made has the offset
//! `RESOLUTION` - f_k from then on. It starts with the value `RESOLUTION` and reaches zero when it
//! has become worse by `RESOLUTION`, so that no function fires at once.

use super::curves::Curve;
use super::flat::Flat;
use super::pins::Pin;
use super::roles::Roles;
use super::{ConvexBody, Corner, Face, Feature, MAX_CORNERS, Owner, Placement, RESOLUTION, Topology, parallel};
use nalgebra::Vector3;

/// Greatest |n . a| of the axis from which tangents of vertex pairs are built.
const STEEPEST: f64 = 0.9;

/// Least of the functions, m; infinite without any. Does not allocate. `distance_scale`: m, turns
/// functions without a unit into distances.
pub fn validity(
    topology: &Topology,
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    distance_scale: f64,
) -> f64 {
    let mut offsets = topology.offsets.iter();
    let mut least = f64::INFINITY;
    visit(topology, a, pa, b, pb, distance_scale, &mut |value| {
        least = least.min(value + offsets.next().copied().unwrap_or(0.0));
    });
    least
}

/// Calls `f` with each function, m, without offsets, in an order that the topology fixes.
pub(super) fn visit(
    topology: &Topology,
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    distance_scale: f64,
    f: &mut impl FnMut(f64),
) {
    if let Some(flat) = Flat::new(topology, [(a, pa), (b, pb)]) {
        flat.visit(topology, f);
        return;
    }
    if let Some(roles) = Roles::new(topology.owner, a, pa, b, pb) {
        visit_face(topology, &roles, f);
        return;
    }
    let pin = match topology.owner {
        Owner::Along(i, j) => {
            let corners = &topology.corners;
            parallel::visit((i, j), corners, (a, pa), (b, pb), f);
            let Some(first) = corners.first() else { return };
            let n = parallel::normal((i, j), (a, pa), (b, pb));
            Pin { n, ..parallel::corner_pin((i, j), first, (a, pa), (b, pb)).0 }
        }
        owner => Pin::new(owner, topology.sign, a, pa, b, pb),
    };
    let (of_a, of_b) = (pa.rotation.tr_mul(&pin.n), pb.rotation.tr_mul(&pin.n));
    let base_a = of_a.dot(&pa.rotation.tr_mul(&(pin.core_a - pa.position)));
    let base_b = pin.n.dot(&(pin.core_a - pb.position)) - pin.distance;
    let Some((feature_a, feature_b)) = topology.owner.features() else { return };
    let (ends_a, ends_b) = (feature_ends(feature_a, a), feature_ends(feature_b, b));
    for (k, x) in a.vertices.iter().enumerate().filter(|_| a.barrel.is_none()) {
        if !ends_a.contains(&(k as u16)) {
            f(of_a.dot(x) - base_a);
        }
    }
    for (k, y) in b.vertices.iter().enumerate().filter(|_| b.barrel.is_none()) {
        if !ends_b.contains(&(k as u16)) {
            f(base_b - of_b.dot(y));
        }
    }
    match topology.owner {
        Owner::Edges(i, _) | Owner::EdgeOfAVertexOfB(i, _) | Owner::Curved(Feature::Edge(i), _) => {
            between(pin.along[0], a.edge(i).length, f);
        }
        _ => {}
    }
    match topology.owner {
        Owner::Edges(_, j) | Owner::VertexOfAEdgeOfB(_, j) | Owner::Curved(_, Feature::Edge(j)) => {
            between(pin.along[1], b.edge(j).length, f);
        }
        _ => {}
    }
    if let Owner::VertexVertex(..) = topology.owner {
        f((STEEPEST - of_a[topology.axis as usize].abs()) * distance_scale);
    }
    if let Owner::Curved(of_a, of_b) = topology.owner {
        let core_b = pin.core_a - pin.n * pin.distance;
        visit_rim((of_a, a, pa), of_b, &pin.core_a, &pin.n, f);
        visit_rim((of_b, b, pb), of_a, &core_b, &-pin.n, f);
    }
}

/// Functions of a rim that touches another feature; `p`: its point, world, m; `n`: into its body.
fn visit_rim(
    (feature, body, at): (Feature, &ConvexBody, &Placement),
    other: Feature,
    p: &Vector3<f64>,
    n: &Vector3<f64>,
    f: &mut impl FnMut(f64),
) {
    let Feature::Rim(k) = feature else { return };
    let rim = Curve::new(body, feature, &at.rotation, &at.position);
    f(n.dot(&(at.point(body.vertex(1 - k)) - rim.at)));
    let arm = p - rim.at;
    let across = n - rim.axis * rim.axis.dot(n);
    match other {
        // Points inside the rim have n outward.
        Feature::Vertex(_) => f(-across.dot(&arm)),
        // n stays on the axis there.
        _ => f(arm.norm() * across.norm() - RESOLUTION),
    }
}

fn between(t: f64, length: f64, f: &mut impl FnMut(f64)) {
    f(t);
    f(length - t);
}

/// Vertices of a body that belong to a feature.
fn feature_ends(feature: Feature, body: &ConvexBody) -> [u16; 2] {
    match feature {
        Feature::Vertex(k) | Feature::Rim(k) => [k; 2],
        Feature::Edge(k) => body.edge(k).ends,
    }
}

fn visit_face(topology: &Topology, roles: &Roles, f: &mut impl FnMut(f64)) {
    let (r, p) = roles.relative();
    let face = roles.owner.face(roles.face);
    let up = r.tr_mul(&face.normal);
    let base = face.offset + roles.other.rounding - face.normal.dot(&p);
    let has_sides = !face.corners.is_empty();
    let signed = |is_corner: bool, value: f64| if is_corner { value } else { -value };
    for (k, x) in roles.other.vertices.iter().enumerate() {
        let k = k as u16;
        if topology.incident.is_some_and(|face| !roles.other.face(face).corners.contains(&k)) {
            f(up.dot(x) - base);
        } else if has_sides {
            let corner = topology.corners.iter().position(|corner| roles.incident_vertex(corner) == Some(k));
            let inside = roles.inside_owner(&(r * x + p));
            f(signed(corner.is_some(), inside));
            if let Some(c) = corner {
                let edges = incident_edges(topology, roles, k);
                f(if is_on_border(topology, c, edges, roles) { -inside } else { f64::INFINITY });
            }
        }
    }
    if let Some(incident) = topology.incident {
        for &k in &face.corners {
            let corner = topology.corners.iter().position(|corner| roles.owner_vertex(corner) == Some(k));
            let inside = roles.inside_incident(incident, &r, &p, roles.owner.vertex(k));
            f(signed(corner.is_some(), inside));
            if let Some(c) = corner {
                f(if is_on_border(topology, c, edges_at(face, k), roles) { -inside } else { f64::INFINITY });
            }
        }
    }
    for (side, edge) in topology.corners.iter().filter_map(|corner| roles.crossing(corner)) {
        let (side, edge) = (roles.owner.edge(side), roles.other.edge(edge));
        let q = face.normal.cross(&side.direction);
        let start = r * roles.other.vertex(edge.ends[0]) + p - roles.owner.vertex(side.ends[0]);
        let e = r * edge.direction;
        let t = side.direction.dot(&(start - e * (q.dot(&start) / q.dot(&e))));
        between(t, side.length, f);
    }
}

/// Edges at the vertex `k` of a face; none without edges.
fn edges_at(face: &Face, k: u16) -> [Option<u16>; 2] {
    let Some(at) = face.corners.iter().position(|&corner| corner == k) else { return [None; 2] };
    let count = face.edges.len();
    if count == 0 { [None; 2] } else { [Some(face.edges[at]), Some(face.edges[(at + count - 1) % count])] }
}

/// Edges of the incident face at the vertex `k` of the other body; of bodies without faces the one that they have.
fn incident_edges(topology: &Topology, roles: &Roles, k: u16) -> [Option<u16>; 2] {
    match topology.incident {
        Some(face) => edges_at(roles.other.face(face), k),
        None => [(!roles.other.edges.is_empty()).then_some(0), None],
    }
}

/// Whether a corner, a vertex with these edges, is on the border of the other face: no neighbour is on one of its
/// edges.
fn is_on_border(topology: &Topology, c: usize, edges: [Option<u16>; 2], roles: &Roles) -> bool {
    let count = topology.corners.len();
    if count == MAX_CORNERS {
        return false;
    }
    let is_owner = roles.owner_vertex(&topology.corners[c]).is_some();
    let (r, p) = roles.relative();
    // A vertex of the other face is on an edge at this corner if it is on the border of the face of the edge.
    let is_border = |inside: f64| inside.abs() <= 10.0 * RESOLUTION;
    let is_on = |edge: u16, corner: &Corner| match (roles.owner_vertex(corner), roles.incident_vertex(corner)) {
        (Some(k), _) if is_owner => roles.owner.edge(edge).ends.contains(&k),
        (_, Some(k)) if !is_owner => roles.other.edge(edge).ends.contains(&k),
        (Some(k), _) => {
            let inside = |face| roles.inside_incident(face, &r, &p, roles.owner.vertex(k));
            topology.incident.is_none_or(|face| is_border(inside(face)))
        }
        (_, Some(k)) => is_border(roles.inside_owner(&(r * roles.other.vertex(k) + p))),
        (None, None) => {
            roles.crossing(corner).is_some_and(|(side, other)| if is_owner { side == edge } else { other == edge })
        }
    };
    let neighbours = [(c + 1) % count, (c + count - 1) % count];
    let is_followed = |edge: u16| neighbours.iter().any(|&n| n != c && is_on(edge, &topology.corners[n]));
    edges.into_iter().flatten().any(|edge| !is_followed(edge))
}
