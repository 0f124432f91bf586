//! Nearest points of the features of owners that are not faces, and their motion.
//!
//! Other owners have core points c_A, c_B with D = c_A - c_B = d n, W = v_A(c_A) - v_B(c_B), and at
//! any gap
//!
//! ```text
//! c = c_A - r_A n        c' = c_A' - r_A n'        g = d - r_A - r_B
//! Edges      N = sigma e_A x e_B   n = N/|N|   n' = (N' - (n . N') n)/|N|
//!            c_A' = v_A(c_A) + s' e_A          s' = (d n' - W) . q/(e_A . q),   q = n x e_B
//! vertices   D' = W                            n' = (D' - (n . D') n)/d,   c_A' = v_A(c_A)
//! A on edge  D' = W - t' e_B                   t' = W . e_B + D . (omega_B x e_B)
//! edge, B    D' = W + s' e_A                   s' = -W . e_A - D . (omega_A x e_A)
//!            c_A' = v_A(c_A) + s' e_A
//! ```
//!
//! The side of a cylinder is its axis, an edge with the rounding R.

use super::{ConvexBody, Owner, Placement};
use nalgebra::Vector3;

/// Rounding, m, of the features of A and B of an owner that is not a face.
pub(super) fn roundings(owner: Owner, a: &ConvexBody, b: &ConvexBody) -> [f64; 2] {
    match owner {
        Owner::Edges(..) | Owner::Along(..) => [a.edge_rounding(), b.edge_rounding()],
        Owner::VertexOfAEdgeOfB(..) => [a.rounding, b.edge_rounding()],
        Owner::EdgeOfAVertexOfB(..) => [a.edge_rounding(), b.rounding],
        Owner::Curved(of_a, of_b) => [a.feature_rounding(of_a), b.feature_rounding(of_b)],
        _ => [a.rounding, b.rounding],
    }
}

/// Sign of e_A x e_B along n. The faces of the edges decide; where they lie in the plane, `n`, any
/// vector on the side of n, world.
pub(super) fn edge_sign(
    a: &ConvexBody,
    pa: &Placement,
    i: u16,
    b: &ConvexBody,
    pb: &Placement,
    j: u16,
    n: &Vector3<f64>,
) -> f64 {
    let (edge_a, edge_b) = (a.edge(i), b.edge(j));
    let cross = (pa.rotation * edge_a.direction).cross(&(pb.rotation * edge_b.direction));
    let into_a = pa.rotation * (edge_a.inward[0] + edge_a.inward[1]);
    let into_b = pb.rotation * (edge_b.inward[0] + edge_b.inward[1]);
    let side = cross.dot(&(into_a - into_b));
    let reference = if side.abs() > super::RESOLUTION * cross.norm() {
        side
    } else if edge_a.has_no_faces() && edge_b.has_no_faces() {
        cross.dot(&(pa.point(a.vertex(edge_a.ends[0])) - pb.point(b.vertex(edge_b.ends[0]))))
    } else {
        cross.dot(n)
    };
    if reference < 0.0 { -1.0 } else { 1.0 }
}

/// Nearest core points of owners that are not faces, and their motion, world.
pub(super) struct Pin {
    /// n and its rate, 1/s.
    pub n: Vector3<f64>,
    pub n_rate: Vector3<f64>,
    /// c_A, m, and its rate, m/s.
    pub core_a: Vector3<f64>,
    pub core_a_rate: Vector3<f64>,
    /// d, m.
    pub distance: f64,
    /// Coordinates of c_A and c_B along their edges, from the first end, m.
    pub along: [f64; 2],
}

impl Pin {
    /// `sign`: of e_A x e_B along n, for edge pairs. Owners that are faces or parallel edges have no pin: it is
    /// zero.
    pub fn new(owner: Owner, sign: f64, a: &ConvexBody, pa: &Placement, b: &ConvexBody, pb: &Placement) -> Self {
        let line = |body: &ConvexBody, at: &Placement, k: u16| {
            let edge = body.edge(k);
            (at.point(body.vertex(edge.ends[0])), at.rotation * edge.direction)
        };
        match owner {
            Owner::Edges(i, j) => {
                let ((p, e_a), (q, e_b)) = (line(a, pa, i), line(b, pb, j));
                Self::crossing(sign, (p, e_a, pa), (q, e_b, pb))
            }
            Owner::VertexVertex(i, j) => {
                let (x, y) = (pa.point(a.vertex(i)), pb.point(b.vertex(j)));
                let d_rate = pa.velocity_at(&x) - pb.velocity_at(&y);
                Self::points(x, pa.velocity_at(&x), &(x - y), &d_rate, [0.0; 2])
            }
            Owner::VertexOfAEdgeOfB(i, j) => {
                let (x, (q, e)) = (pa.point(a.vertex(i)), line(b, pb, j));
                let t = e.dot(&(x - q));
                let foot = q + e * t;
                let (apart, w) = (x - foot, pa.velocity_at(&x) - pb.velocity_at(&foot));
                let t_rate = w.dot(&e) + apart.dot(&pb.omega.cross(&e));
                Self::points(x, pa.velocity_at(&x), &apart, &(w - e * t_rate), [0.0, t])
            }
            Owner::EdgeOfAVertexOfB(i, j) => {
                let (y, (p, e)) = (pb.point(b.vertex(j)), line(a, pa, i));
                let s = e.dot(&(y - p));
                let foot = p + e * s;
                let (apart, v) = (foot - y, pa.velocity_at(&foot));
                let w = v - pb.velocity_at(&y);
                let s_rate = -w.dot(&e) - apart.dot(&pa.omega.cross(&e));
                Self::points(foot, v + e * s_rate, &apart, &(w + e * s_rate), [s, 0.0])
            }
            Owner::Curved(of_a, of_b) => Self::curved((of_a, a, pa), (of_b, b, pb)),
            Owner::FaceOfA(_) | Owner::FaceOfB(_) | Owner::Along(..) => {
                let zero = Vector3::zeros();
                Self::points(zero, zero, &zero, &zero, [0.0; 2])
            }
        }
    }

    /// Points apart by D = `apart` with the rate D' = `apart_rate`.
    fn points(
        core_a: Vector3<f64>,
        core_a_rate: Vector3<f64>,
        apart: &Vector3<f64>,
        apart_rate: &Vector3<f64>,
        along: [f64; 2],
    ) -> Self {
        let distance = apart.norm();
        let scale = if distance > 0.0 { 1.0 / distance } else { 0.0 };
        let n = apart * scale;
        let n_rate = (apart_rate - n * n.dot(apart_rate)) * scale;
        Pin { n, n_rate, core_a, core_a_rate, distance, along }
    }

    /// Lines given by a point, a direction and the motion of their bodies.
    fn crossing(
        sign: f64,
        (p, e_a, pa): (Vector3<f64>, Vector3<f64>, &Placement),
        (q, e_b, pb): (Vector3<f64>, Vector3<f64>, &Placement),
    ) -> Self {
        let cross = e_a.cross(&e_b) * sign;
        let norm = cross.norm();
        let scale = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        let n = cross * scale;
        let cross_rate = (pa.omega.cross(&e_a).cross(&e_b) + e_a.cross(&pb.omega.cross(&e_b))) * sign;
        let n_rate = (cross_rate - n * n.dot(&cross_rate)) * scale;
        // e_A . (n x e_B) = -sigma |N|, and e_B . (n x e_A) = sigma |N|.
        let apart = p - q;
        let (across_a, across_b) = (n.cross(&e_b), n.cross(&e_a));
        let s = apart.dot(&across_a) * sign * scale;
        let t = apart.dot(&across_b) * sign * scale;
        let (core_a, distance) = (p + e_a * s, n.dot(&apart));
        let core_b = q + e_b * t;
        let w = pa.velocity_at(&core_a) - pb.velocity_at(&core_b);
        let s_rate = -(n_rate * distance - w).dot(&across_a) * sign * scale;
        let core_a_rate = pa.velocity_at(&core_a) + e_a * s_rate;
        Pin { n, n_rate, core_a, core_a_rate, distance, along: [s, t] }
    }
}
