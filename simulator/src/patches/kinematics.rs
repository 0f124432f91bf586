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
//! Other owners are in `pins`, cylinders on faces in `flat`, rims in `curves`, parallel edges in `parallel`.

use super::flat::Flat;
use super::parallel;
use super::pins::{Pin, edge_sign, roundings};
use super::roles::Roles;
use super::{ConvexBody, Corner, CornerMotion, Feature, Owner, PatchGeometry, Placement, Topology};
use nalgebra::{Matrix3, Vector3};

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
    CornerMotion { position: c, gap, bias: turn + n * n_rate.dot(&velocity), velocity, normal_rate: *n_rate }
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
