//! Parallel edges that touch along a segment: capsules, sides of cylinders and edges of polyhedra, of
//! which at least one is round.
//!
//! The segment is the overlap of both edges. Its two corners are ends of either edge; each has the nearest
//! points of this end and the other edge (of cylinders, of the rim of this end), which are exact at any
//! gap and inclination. With their directions n_1, n_2, the patch has n = (n_1 + n_2)/|n_1 + n_2|.
//!
//! Edges that turn against each other about n cross between the corners; they are then lower there by
//! b = a^2/(2 d), with the distance d of the cores and the distance a across n at a corner. Up to
//! `RESOLUTION` they count as parallel.

use super::pins::{Pin, roundings};
use super::roles::Placed;
use super::{Corner, Feature, Owner, RESOLUTION};
use nalgebra::Vector3;

/// Least length of a segment, m.
const SHORTEST: f64 = 1e-6;

/// Sine of the angle between edges above which they are not parallel, whatever their lengths.
const CROSSED: f64 = 1e-2;

/// The owner of the pin of a corner.
pub(super) fn corner_owner((i, j): (u16, u16), corner: &Corner, (a, _): Placed, (b, _): Placed) -> Owner {
    match *corner {
        Corner::B(k) if b.barrel.is_some() => Owner::Curved(Feature::Edge(i), Feature::Rim(k)),
        Corner::B(k) => Owner::EdgeOfAVertexOfB(i, k),
        Corner::A(k) if a.barrel.is_some() => Owner::Curved(Feature::Rim(k), Feature::Edge(j)),
        Corner::A(k) | Corner::Crossing { a: k, .. } => Owner::VertexOfAEdgeOfB(k, j),
    }
}

/// Nearest points at a corner, and the gap, m.
pub(super) fn corner_pin(edges: (u16, u16), corner: &Corner, a: Placed, b: Placed) -> (Pin, f64) {
    let owner = corner_owner(edges, corner, a, b);
    let pin = Pin::new(owner, 1.0, a.0, a.1, b.0, b.1);
    let [r_a, r_b] = roundings(owner, a.0, b.0);
    let gap = pin.distance - r_a - r_b;
    (pin, gap)
}

/// Direction of A's edge, world.
fn along((i, _): (u16, u16), (a, pa): Placed) -> Vector3<f64> {
    pa.rotation * a.edge(i).direction
}

/// The ends of the overlap, along A's edge, and its length, m.
pub(super) fn overlap((i, j): (u16, u16), (a, pa): Placed, (b, pb): Placed) -> ([Corner; 2], f64) {
    let (edge_a, edge_b) = (a.edge(i), b.edge(j));
    let (e, start) = (along((i, j), (a, pa)), pa.point(a.vertex(edge_a.ends[0])));
    let at = |k: u16| e.dot(&(pb.point(b.vertex(k)) - start));
    let [mut low, mut high] = edge_b.ends;
    if at(low) > at(high) {
        (low, high) = (high, low);
    }
    let first = if at(low) > RESOLUTION { Corner::B(low) } else { Corner::A(edge_a.ends[0]) };
    let last = if at(high) < edge_a.length - RESOLUTION { Corner::B(high) } else { Corner::A(edge_a.ends[1]) };
    ([first, last], at(high).min(edge_a.length) - at(low).max(0.0))
}

/// The normal n of the patch; zero without corners.
pub(super) fn normal(edges: (u16, u16), a: Placed, b: Placed) -> Vector3<f64> {
    let (corners, _) = overlap(edges, a, b);
    let sum = corners.map(|corner| corner_pin(edges, &corner, a, b).0.n).iter().sum::<Vector3<f64>>();
    sum.try_normalize(0.0).unwrap_or_default()
}

/// The edges along which bodies touch whose owner is `found` with the separation `distance`, m, if they do.
pub(super) fn owner(found: Owner, distance: f64, a: Placed, b: Placed) -> Option<Owner> {
    if !(a.0.is_round() || b.0.is_round()) || a.0.edges.is_empty() || b.0.edges.is_empty() {
        return None;
    }
    if let Owner::Along(..) = found {
        return None;
    }
    let (of_a, of_b) = found.features()?;
    let has = |(body, _): Placed, feature: Feature, k: usize| match feature {
        Feature::Edge(edge) => edge as usize == k,
        Feature::Rim(_) => k == 0,
        Feature::Vertex(vertex) => body.edges[k].ends.contains(&vertex),
    };
    for i in (0..a.0.edges.len()).filter(|&i| has(a, of_a, i)) {
        for j in (0..b.0.edges.len()).filter(|&j| has(b, of_b, j)) {
            let edges = (i as u16, j as u16);
            let cross = along(edges, a).cross(&(b.1.rotation * b.0.edges[j].direction));
            let (corners, length) = overlap(edges, a, b);
            let touches = |corner: &Corner| corner_pin(edges, corner, a, b).1 <= distance + RESOLUTION;
            if cross.norm() < CROSSED && length > SHORTEST && corners.iter().all(touches) {
                return Some(Owner::Along(edges.0, edges.1));
            }
        }
    }
    None
}

/// Functions of the validity: the crossing of the edges, and which ends are corners.
pub(super) fn visit(edges: (u16, u16), corners: &[Corner], a: Placed, b: Placed, f: &mut impl FnMut(f64)) {
    let n = normal(edges, a, b);
    let across = n.cross(&along(edges, a));
    let mut least = f64::INFINITY;
    for corner in corners {
        let (pin, _) = corner_pin(edges, corner, a, b);
        let off = pin.distance * across.dot(&pin.n);
        least = least.min(RESOLUTION - off * off / (2.0 * pin.distance.max(RESOLUTION)));
    }
    f(least);
    let (edge_a, edge_b) = (a.0.edge(edges.0), b.0.edge(edges.1));
    let inside = |x: &Vector3<f64>, (body, at): Placed, edge: &super::Edge| {
        let t = (at.rotation * edge.direction).dot(&(x - at.point(body.vertex(edge.ends[0]))));
        t.min(edge.length - t)
    };
    let mut signed = |corner: Corner, value: f64| f(if corners.contains(&corner) { value } else { -value });
    for k in edge_a.ends {
        signed(Corner::A(k), inside(&a.1.point(a.0.vertex(k)), b, edge_b));
    }
    for k in edge_b.ends {
        signed(Corner::B(k), inside(&b.1.point(b.0.vertex(k)), a, edge_a));
    }
}
