//! Topology of a patch: clips the incident polygon against the sides of the owner's face.
//!
//! Points of the incident polygon are kept in the frame of the owner, on the incident face. With
//! u_k the vector into the owner's face from its side k, through its corner w_k, the inner distance
//! of a point x is
//!
//! ```text
//! d_k(x) = u_k . (x - w_k)
//! ```
//!
//! Points with d_k >= -`RESOLUTION` are kept as they are. An edge that leads from d_k > `RESOLUTION`
//! to d_k < -`RESOLUTION` gets a crossing. Each line of the clipped polygon is an edge of the
//! incident polygon or a side of the owner, so that each corner is named by two lines: a vertex of
//! the incident polygon, a crossing, or a corner of the owner.

use super::flat::Flat;
use super::kinematics::plane_normal;
use super::parallel;
use super::pins::{Pin, edge_sign, roundings};
use super::roles::{Roles, UPRIGHT, incident_face};
use super::{ConvexBody, Corner, Feature, MAX_CORNERS, Owner, Placement, RESOLUTION, Topology, validity};
use nalgebra::{Matrix3, Vector3};

/// A line of the clipped polygon: an edge of the other body or a side of the owner's face.
#[derive(Clone, Copy, PartialEq)]
enum Line {
    Edge(u16),
    Side(usize),
}

/// A point of the clipped polygon and the line that starts there.
#[derive(Clone, Copy)]
struct Point {
    /// `None` for intersections of sides of the owner that are not its corners.
    corner: Option<Corner>,
    x: Vector3<f64>,
    line: Line,
}

/// Determines the corners of the patch of `owner` at the given configuration.
///
/// Corners with gaps greater than `near`, m, are kept; without any other the result is `false`, as
/// it is when edges cross beyond their ends.
/// `present`: the incident face to prefer among those equally opposed. For edge pairs that lie
/// in faces parallel to the plane (flat plates) n takes the side of the normal of the topology that
/// `out` holds before. Where one body is a half-space, its face must be the owner.
#[allow(clippy::too_many_arguments)]
pub fn topology(
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    near: f64,
    owner: Owner,
    present: Option<u16>,
    out: &mut Topology,
) -> bool {
    let rings = std::mem::take(&mut out.rings);
    let is_near = if let Some(flat) = Flat::of(owner, rings, [(a, pa), (b, pb)]) {
        out.owner = owner;
        flat.build(near, present, out)
    } else if let Some(roles) = Roles::new(owner, a, pa, b, pb) {
        clip(&roles, near, owner, present, out)
    } else {
        pinned(a, pa, b, pb, near, owner, out)
    };
    out.offsets.clear();
    if is_near {
        let mut offsets = std::mem::take(&mut out.offsets);
        validity::visit(out, a, pa, b, pb, 1.0, &mut |value| offsets.push((RESOLUTION - value).max(0.0)));
        out.offsets = offsets;
    }
    is_near
}

/// Topology of owners that are not faces: one corner, or two of parallel edges.
fn pinned(
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    near: f64,
    owner: Owner,
    out: &mut Topology,
) -> bool {
    let corner = match owner {
        Owner::Along(i, j) => {
            let (a, b) = ((a, pa), (b, pb));
            let (corners, length) = parallel::overlap((i, j), a, b);
            (out.owner, out.incident) = (owner, None);
            out.corners.clear();
            out.corners.extend(corners);
            let gap = |corner: &Corner| parallel::corner_pin((i, j), corner, a, b).1;
            return length > 0.0 && corners.iter().any(|corner| gap(corner) <= near);
        }
        Owner::Edges(i, j) => {
            let is_valid = has_features(out.owner, a, b) && !out.corners.is_empty();
            let before = if is_valid { plane_normal(out.owner, a, pa, b, pb) } else { Vector3::zeros() };
            let apart = pa.point(&a.centre) - pb.point(&b.centre);
            let side = if before == Vector3::zeros() { apart } else { before };
            out.sign = edge_sign(a, pa, i, b, pb, j, &side);
            Corner::Crossing { a: i, b: j }
        }
        Owner::EdgeOfAVertexOfB(_, j) => Corner::B(j),
        Owner::VertexVertex(i, _) | Owner::VertexOfAEdgeOfB(i, _) => Corner::A(i),
        Owner::Curved(_, Feature::Vertex(j)) => Corner::B(j),
        Owner::Curved(Feature::Rim(i) | Feature::Vertex(i), _) => Corner::A(i),
        Owner::Curved(_, Feature::Rim(j) | Feature::Edge(j)) => Corner::B(j),
        Owner::FaceOfA(_) | Owner::FaceOfB(_) => return false,
    };
    out.axis = pa.rotation.tr_mul(&plane_normal(owner, a, pa, b, pb)).iamin() as u8;
    (out.owner, out.incident) = (owner, None);
    out.corners.clear();
    out.corners.push(corner);
    let pin = Pin::new(owner, out.sign, a, pa, b, pb);
    let is_on = |t: f64, length: f64| t >= -RESOLUTION && t <= length + RESOLUTION;
    let is_within = match owner {
        Owner::Edges(i, j) => is_on(pin.along[0], a.edge(i).length) && is_on(pin.along[1], b.edge(j).length),
        Owner::EdgeOfAVertexOfB(i, _) => is_on(pin.along[0], a.edge(i).length),
        Owner::Curved(Feature::Edge(i), _) => is_on(pin.along[0], a.edge(i).length),
        Owner::VertexOfAEdgeOfB(_, j) | Owner::Curved(_, Feature::Edge(j)) => is_on(pin.along[1], b.edge(j).length),
        _ => true,
    };
    let [r_a, r_b] = roundings(owner, a, b);
    is_within && pin.distance - r_a - r_b <= near
}

/// Whether the bodies have the features of an owner that is a face or an edge pair.
fn has_features(owner: Owner, a: &ConvexBody, b: &ConvexBody) -> bool {
    match owner {
        Owner::FaceOfA(i) => (i as usize) < a.faces.len(),
        Owner::FaceOfB(i) => (i as usize) < b.faces.len(),
        Owner::Edges(i, j) => (i as usize) < a.edges.len() && (j as usize) < b.edges.len(),
        _ => false,
    }
}

fn clip(roles: &Roles, near: f64, owner: Owner, present: Option<u16>, out: &mut Topology) -> bool {
    out.corners.clear();
    (out.owner, out.incident) = (owner, None);
    if roles.other.is_half_space() {
        return false;
    }
    let (r, p) = roles.relative();
    let face = roles.owner.face(roles.face);
    let m = face.normal;
    let gap = |x: &Vector3<f64>| m.dot(x) - face.offset - roles.other.rounding;
    let is_near = |k: &u16| gap(&(r * roles.other.vertex(*k) + p)) <= near;
    out.incident = incident_face(roles, &(r.tr_mul(&m)), present, is_near);
    let mut points = incident_polygon(roles, out.incident, &r, &p);
    for side in 0..face.corners.len() {
        points = cut(roles, points, side);
    }
    let has_inside = out.incident.is_some_and(|k| m.dot(&(r * roles.other.face(k).normal)) < -UPRIGHT);
    for point in &mut points {
        snap(roles, point, has_inside);
    }
    points.retain(|point| point.corner.is_some());
    merge(roles, &mut points);
    if points.len() > MAX_CORNERS {
        points = (0..MAX_CORNERS).map(|k| points[k * points.len() / MAX_CORNERS]).collect();
    }
    out.corners.extend(points.iter().filter_map(|point| point.corner));
    if !roles.is_owner_b {
        out.corners.reverse();
    }
    points.iter().any(|point| gap(&point.x) <= near)
}

/// The incident polygon, counter-clockwise about the owner's normal. Bodies without faces have their
/// point, or their edge there and back.
fn incident_polygon(roles: &Roles, incident: Option<u16>, r: &Matrix3<f64>, p: &Vector3<f64>) -> Vec<Point> {
    let point = |k: u16, edge: u16| {
        let corner = Some(roles.incident_corner(k));
        Point { corner, x: r * roles.other.vertex(k) + p, line: Line::Edge(edge) }
    };
    match incident {
        Some(k) => {
            // Against the order of the face, as its own normal is opposite.
            let (ring, edges) = (&roles.other.face(k).corners, &roles.other.face(k).edges);
            let count = ring.len();
            (0..count).rev().map(|k| point(ring[k], edges[(k + count - 1) % count])).collect()
        }
        None => (0..roles.other.vertices.len() as u16).map(|k| point(k, 0)).collect(),
    }
}

/// Keeps the part of a polygon inside of one side of the owner's face.
fn cut(roles: &Roles, points: Vec<Point>, side: usize) -> Vec<Point> {
    let inward = *roles.owner.side_inward(roles.face, side);
    let origin = *roles.owner.vertex(roles.owner.face(roles.face).corners[side]);
    let distance = |point: &Point| inward.dot(&(point.x - origin));
    let mut kept = Vec::with_capacity(points.len() + 2);
    for (k, point) in points.iter().enumerate() {
        let next = &points[(k + 1) % points.len()];
        let (from, to) = (distance(point), distance(next));
        let crossing = |line: Line| {
            let x = point.x + (next.x - point.x) * (from / (from - to));
            Point { corner: intersection(roles, point.line, side), x, line }
        };
        if from >= -RESOLUTION {
            let is_border = from <= RESOLUTION && to < -RESOLUTION;
            kept.push(Point { line: if is_border { Line::Side(side) } else { point.line }, ..*point });
            if from > RESOLUTION && to < -RESOLUTION {
                kept.push(crossing(Line::Side(side)));
            }
        } else if to > RESOLUTION {
            kept.push(crossing(point.line));
        }
    }
    kept
}

/// The corner where a line meets a side of the owner.
fn intersection(roles: &Roles, line: Line, side: usize) -> Option<Corner> {
    let face = roles.owner.face(roles.face);
    let count = face.corners.len();
    match line {
        Line::Edge(edge) => Some(roles.crossing_corner(face.edges[side], edge)),
        Line::Side(other) if (other + 1) % count == side => Some(roles.owner_corner(face.corners[side])),
        Line::Side(other) if (side + 1) % count == other => Some(roles.owner_corner(face.corners[other])),
        Line::Side(_) => None,
    }
}

/// Replaces a crossing at a corner of the owner by this corner, and drops corners of the owner where
/// the incident polygon has no inside.
fn snap(roles: &Roles, point: &mut Point, has_inside: bool) {
    let Some(corner) = point.corner else { return };
    if roles.owner_vertex(&corner).is_some() && !has_inside {
        point.corner = None;
    }
    if roles.crossing(&corner).is_none() || !has_inside {
        return;
    }
    let face = roles.owner.face(roles.face);
    let is_at = |k: &&u16| {
        let apart = point.x - roles.owner.vertex(**k);
        (apart - face.normal * face.normal.dot(&apart)).norm() <= RESOLUTION
    };
    if let Some(&k) = face.corners.iter().find(is_at) {
        point.corner = Some(roles.owner_corner(k));
    }
}

/// Merges neighbours that are one point: vertices of the other body are kept first, crossings last.
fn merge(roles: &Roles, points: &mut Vec<Point>) {
    let rank = |point: &Point| match &point.corner {
        Some(corner) if roles.incident_vertex(corner).is_some() => 2,
        Some(corner) if roles.owner_vertex(corner).is_some() => 1,
        _ => 0,
    };
    let mut k = 0;
    while points.len() > 1 && k < points.len() {
        let next = (k + 1) % points.len();
        let is_same = points[k].corner == points[next].corner;
        if is_same || (points[k].x - points[next].x).norm() <= RESOLUTION {
            let drop = if rank(&points[k]) >= rank(&points[next]) { next } else { k };
            points.remove(drop);
            k = k.saturating_sub(1);
        } else {
            k += 1;
        }
    }
}
