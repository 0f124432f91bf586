//! Axes, positions, gaps, velocities and bias accelerations of the corners of a held topology.
//!
//! Bodies A and B have the origins x_A, x_B, the angular velocities omega_A, omega_B and the
//! material velocities v_A(x) = x_A' + omega_A x (x - x_A). A corner has the contact point c(t), the
//! gap g along n and the relative velocity v_rel = v_A(c) - v_B(c). Then dg/dt = n . v_rel, and
//!
//! ```text
//! d2g/dt2       = n . d/dt v_rel(c(t)) + n' . v_rel
//! d/dt v_rel    = (x_A'' + alpha_A x (c - x_A)) - (x_B'' + alpha_B x (c - x_B))
//!               + omega_A x (c' - x_A') - omega_B x (c' - x_B')
//! bias          = omega_A x (c' - x_A') - omega_B x (c' - x_B') + (n' . v_rel) n
//! ```
//!
//! so that d/dt v_rel + (n' . v_rel) n is the relative acceleration of the bodies at c, without
//! centripetal terms, plus bias; its part along n is d2g/dt2.
//!
//! Owner is a face with the outward normal m of the body O; I is the other body, with rounding r;
//! n = m if O is B, otherwise n = -m. Here m' = omega_O x m, and
//!
//! ```text
//! vertex x of I       c = x - r m          c' = v_I(x) - r m'           g = height(x) - r
//! vertex w of O       c = w + g m          c' = v_O(c)                  g = m_I . (z - w)/(m_I . m)
//! edge e of I across  c = z - r m          c' = v_I(z) + s' e - r m'    g = height(z) - r
//! the side q of O     z = P + s e          s' = -q . (v_I(z) - v_O(z))/(q . e),  q . (z - Q) = 0
//! ```
//!
//! with a point z and the normal m_I of the incident face, and q = m x e_O fixed in O. The vertex of
//! I has all formulas at any gap. The two other kinds have them where the incident face or edge is
//! parallel to the plane and the relative angular velocity is along n, as in a closed patch.
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
//! Cylinders on faces are in `flat`, rims in `curves`, and parallel edges in `parallel`. The side of a
//! cylinder is its axis, an edge with the rounding R.

use super::flat::Flat;
use super::parallel;
use super::roles::Roles;
use super::{ConvexBody, Corner, CornerMotion, Feature, Owner, PatchGeometry, Placement, Topology};
use nalgebra::{Matrix3, Vector3};

/// A body and its placement.
pub(super) type Placed<'a> = (&'a ConvexBody, &'a Placement);

/// Computes axes and corners of a held topology. Does not allocate once `out` has room.
pub fn geometry(
    topology: &Topology,
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
    out: &mut PatchGeometry,
) {
    out.points.clear();
    if let Some(roles) = Roles::new(topology.owner, a, pa, b, pb) {
        let m = roles.owner_at.rotation * roles.owner.face(roles.face).normal;
        let n = if roles.is_owner_b { m } else { -m };
        let n_rate = roles.owner_at.omega.cross(&n);
        out.axes = axes(&n, &(roles.owner_at.rotation * face_tangent(roles.owner, roles.face)));
        let flat = Flat::new(topology, [(a, pa), (b, pb)]);
        for corner in &topology.corners {
            let (c, c_rate, gap) = match &flat {
                Some(flat) => flat.corner(corner),
                None => on_face(&roles, topology.incident, corner, &m),
            };
            out.points.push(motion(pa, pb, c, &c_rate, gap, &n, &n_rate));
        }
        return;
    }
    if let Owner::Along(i, j) = topology.owner {
        let (a, b) = ((a, pa), (b, pb));
        out.axes = axes(&parallel::normal((i, j), a, b), &(pa.rotation * a.0.edge(i).direction));
        for corner in &topology.corners {
            let (pin, gap) = parallel::corner_pin((i, j), corner, a, b);
            let [r_a, _] = roundings(parallel::corner_owner((i, j), corner, a, b), a.0, b.0);
            let (c, c_rate) = (pin.core_a - pin.n * r_a, pin.core_a_rate - pin.n_rate * r_a);
            out.points.push(motion(pa, pb, c, &c_rate, gap, &pin.n, &pin.n_rate));
        }
        return;
    }
    let pin = Pin::new(topology.owner, topology.sign, a, pa, b, pb);
    let tangent = match topology.owner {
        Owner::Edges(i, _) | Owner::EdgeOfAVertexOfB(i, _) | Owner::Curved(Feature::Edge(i), _) => {
            pa.rotation * a.edge(i).direction
        }
        Owner::VertexOfAEdgeOfB(_, j) | Owner::Curved(_, Feature::Edge(j)) => pb.rotation * b.edge(j).direction,
        Owner::Curved(Feature::Rim(_), _) => (pa.rotation * a.axis()).cross(&pin.n),
        Owner::Curved(_, Feature::Rim(_)) => (pb.rotation * b.axis()).cross(&pin.n),
        _ => pa.rotation.column(topology.axis as usize).into(),
    };
    out.axes = axes(&pin.n, &tangent);
    let [r_a, r_b] = roundings(topology.owner, a, b);
    let c = pin.core_a - pin.n * r_a;
    let c_rate = pin.core_a_rate - pin.n_rate * r_a;
    let gap = pin.distance - r_a - r_b;
    out.points.extend(topology.corners.iter().map(|_| motion(pa, pb, c, &c_rate, gap, &pin.n, &pin.n_rate)));
}

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

/// Unit normal n of an owner, world, from B into A; zero where it is not defined.
pub(super) fn plane_normal(
    owner: Owner,
    a: &ConvexBody,
    pa: &Placement,
    b: &ConvexBody,
    pb: &Placement,
) -> Vector3<f64> {
    match owner {
        Owner::FaceOfA(i) => -(pa.rotation * a.face(i).normal),
        Owner::FaceOfB(i) => pb.rotation * b.face(i).normal,
        Owner::Edges(i, j) => {
            let apart = pa.point(&a.centre) - pb.point(&b.centre);
            Pin::new(owner, edge_sign(a, pa, i, b, pb, j, &apart), a, pa, b, pb).n
        }
        Owner::Along(i, j) => parallel::normal((i, j), (a, pa), (b, pb)),
        _ => Pin::new(owner, 1.0, a, pa, b, pb).n,
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

/// Direction in a face along its first edge, body frame; the x axis for half-spaces.
fn face_tangent(body: &ConvexBody, face: u16) -> Vector3<f64> {
    body.face(face).edges.first().map_or(Vector3::x(), |&k| body.edge(k).direction)
}

/// Orthonormal axes with the column 2 along `n` and the column 0 nearest to `tangent`.
fn axes(n: &Vector3<f64>, tangent: &Vector3<f64>) -> Matrix3<f64> {
    let t = (tangent - n * n.dot(tangent)).try_normalize(0.0).unwrap_or_default();
    Matrix3::from_columns(&[t, n.cross(&t), *n])
}

fn motion(
    pa: &Placement,
    pb: &Placement,
    c: Vector3<f64>,
    c_rate: &Vector3<f64>,
    gap: f64,
    n: &Vector3<f64>,
    n_rate: &Vector3<f64>,
) -> CornerMotion {
    let velocity = pa.velocity_at(&c) - pb.velocity_at(&c);
    let turn = pa.omega.cross(&(c_rate - pa.velocity)) - pb.omega.cross(&(c_rate - pb.velocity));
    CornerMotion { position: c, gap, bias: turn + n * n_rate.dot(&velocity), velocity }
}

/// Position c, m, rate c', m/s, and gap, m, of a corner on the face of an owner with the normal `m`.
fn on_face(
    roles: &Roles,
    incident: Option<u16>,
    corner: &Corner,
    m: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>, f64) {
    let Roles { owner, owner_at, face, other, other_at, .. } = *roles;
    let (r, m_rate) = (other.rounding, owner_at.omega.cross(m));
    let height = |x: &Vector3<f64>| m.dot(&(x - owner_at.position)) - owner.face(face).offset;
    if let Some(k) = roles.incident_vertex(corner) {
        let x = other_at.point(other.vertex(k));
        return (x - m * r, other_at.velocity_at(&x) - m_rate * r, height(&x) - r);
    }
    if let Some((k, l)) = roles.crossing(corner) {
        let (side, edge) = (owner.edge(k), other.edge(l));
        let q = m.cross(&(owner_at.rotation * side.direction));
        let (e, start) = (other_at.rotation * edge.direction, other_at.point(other.vertex(edge.ends[0])));
        let across = q.dot(&e);
        let s = q.dot(&(owner_at.point(owner.vertex(side.ends[0])) - start)) / across;
        let z = start + e * s;
        let v = other_at.velocity_at(&z);
        let s_rate = -q.dot(&(v - owner_at.velocity_at(&z))) / across;
        return (z - m * r, v + e * s_rate - m_rate * r, height(&z) - r);
    }
    let w = owner_at.point(owner.vertex(roles.owner_vertex(corner).unwrap_or(0)));
    let gap = incident.map_or(f64::INFINITY, |k| {
        let incident = other.face(k);
        let m_i = other_at.rotation * incident.normal;
        (incident.offset - m_i.dot(&(w - other_at.position))) / m_i.dot(m)
    });
    let c = if incident.is_some() { w + m * gap } else { w };
    (c, owner_at.velocity_at(&c), gap)
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
