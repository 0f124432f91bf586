//! Patches on faces where one of the bodies is a cylinder.
//!
//! O owns the plane with the outward normal m, I is the other body. The regions that overlap in the plane
//! have borders of lines and circles:
//!
//! ```text
//! O   half-space: no border         polygon: its sides       end of a cylinder: its rim
//! I   face: its sides               segment: itself          end of a cylinder: its rim
//!     cylinder that does not touch with an end: the generator between the rim points c_k + R u,
//!     u = -P m/|P m| (see `cylinder`), of which the lower one touches unless the axis is level
//! ```
//!
//! Corners are the vertices of I inside O, the vertices of O inside I, and the crossings of the borders;
//! vertices of ends are the points of their rings. With the distance d inside a circle or inside all sides,
//! and the measure g of a crossing, positive if it exists (parameters within both lines, and the depth of
//! a line in a circle), the functions of the validity are
//!
//! ```text
//! + d or - d, + g or - g                        vertices, crossings; + for corners
//! - d                                           vertices with a crossing in their place
//! height of x                                   vertices x of I outside its face
//! height of x + `DIPPED`                        vertices x of its face outside O
//! R (|P m| - 1/2) or, if that is less,
//! R |P m| (u . w - 1/2)                         w: u when the topology was made
//! R (|P m| - `LANDED`)                           rims: the end is not flat
//! R (max_k -P m . w_k - |P m|)                  ends of I: the rim is not below the ring
//! R (`TIPPED` - |P m|)                          ends of I
//! ```
//!
//! The third is negative when the axis has passed the normal, where u jumps to the other side. There u keeps to
//! that of w, so that the motion up to the event is smooth. A crossing z with
//! the tangent e of I's border and the normal q of O's border in the plane (`borders`) moves with
//!
//! ```text
//! z' = v_I(z) + R u'_I + s' e        s' = -q . (v_I(z) + R u'_I - v_O(z))/(q . e)
//! u'_I = -t (t . (omega_O - omega_I) x m)/|P m|,  t = a x u     generators; zero otherwise
//! ```

mod rings;

use super::borders::{Border, Crossing};
use super::cylinder::{RING, rim_edge, ring_of, ring_vertex, shortest, side_of_rim};
use super::roles::{Placed, Roles, UPRIGHT, incident_face};
use super::{ConvexBody, Corner, MAX_CORNERS, Owner, Placement, RESOLUTION, Topology};
use nalgebra::Vector3;

/// Sine of the tilt beyond which an end does not touch with its ring.
const TIPPED: f64 = 1e-3;

/// Sine of the tilt at which a rim that comes down becomes an end: closer to the normal, noise moves its point.
const LANDED: f64 = 1e-6;

/// Sine of the tilt below which w must be near u. Below half of it the rim point keeps to the side of w.
const STEEP: f64 = 0.5;

/// Depth below the plane of the owner, m, of a point of the incident face outside the owner. Beyond it the bodies have
/// turned about a crossing, and touch along its rim and edge.
const DIPPED: f64 = 1e-6;

/// Sine of a tilt up to which an end has no direction of its own.
const LEVEL: f64 = 1e-7;

/// A point of the patch while it is made.
struct Point {
    corner: Corner,
    x: Vector3<f64>,
    rank: u8,
    /// Whether it is a vertex with a crossing in its place.
    is_crossed: bool,
}

/// Owner and other body in the world.
pub(super) struct Flat<'a> {
    roles: Roles<'a>,
    /// m, world.
    m: Vector3<f64>,
    incident: Option<u16>,
    /// Directions w of the rings of the owner and the other body, in their frames.
    rings: [Vector3<f64>; 2],
}

impl<'a> Flat<'a> {
    /// `None` for owners that are not faces, and without cylinders.
    pub fn new(topology: &Topology, bodies: [Placed<'a>; 2]) -> Option<Self> {
        let flat = Self::of(topology.owner, topology.rings, bodies)?;
        Some(Flat { incident: topology.incident, ..flat })
    }

    /// As [`new`](Self::new), before the end of the other body is known. `rings`: of A and B.
    pub fn of(owner: Owner, rings: [Vector3<f64>; 2], [a, b]: [Placed<'a>; 2]) -> Option<Self> {
        let roles = Roles::new(owner, a.0, a.1, b.0, b.1)?;
        if roles.owner.barrel.is_none() && roles.other.barrel.is_none() {
            return None;
        }
        let [of_a, of_b] = rings;
        let rings = if roles.is_owner_b { [of_b, of_a] } else { [of_a, of_b] };
        let m = roles.owner_at.rotation * roles.owner.face(roles.face).normal;
        Some(Flat { roles, m, incident: None, rings })
    }

    /// m in the frame of the other body.
    fn down(&self) -> Vector3<f64> {
        self.roles.other_at.rotation.tr_mul(&self.m)
    }

    /// u, world, of a cylinder that touches with its rim or its side, and |P m| with the sign of its equation.
    fn side(&self) -> Option<(Vector3<f64>, f64)> {
        let Roles { other, other_at, .. } = self.roles;
        other.barrel.filter(|_| self.incident.is_none())?;
        let (across, w) = (other.across(&self.down()), self.rings[1]);
        let tilt = across.norm();
        let size = if tilt < 0.5 * STEEP && across.dot(&w) > 0.0 { -tilt } else { tilt };
        let u = if size == 0.0 { w } else { across / -size };
        Some((other_at.rotation * u, size))
    }

    fn height(&self, x: &Vector3<f64>) -> f64 {
        let Roles { owner, owner_at, face, .. } = self.roles;
        self.m.dot(&(x - owner_at.position)) - owner.face(face).offset
    }

    /// Whether the overlap of I can have an inside.
    fn has_inside(&self) -> bool {
        self.incident.is_some_and(|k| self.down().dot(&self.roles.other.face(k).normal) < -UPRIGHT)
    }

    /// The vertices of I that may be corners, world, m.
    fn visit_other(&self, f: &mut impl FnMut(u16, Vector3<f64>)) {
        let Roles { other, other_at, .. } = self.roles;
        match (other.barrel, self.incident) {
            (Some(_), Some(end)) => {
                (0..RING).for_each(|k| f(ring_vertex(end, k), self.vertex_of_other(ring_vertex(end, k))));
            }
            (None, Some(face)) => other.face(face).corners.iter().for_each(|&k| f(k, other_at.point(other.vertex(k)))),
            (_, None) => (0..other.vertices.len() as u16).for_each(|k| f(k, self.vertex_of_other(k))),
        }
    }

    fn vertex_of_other(&self, k: u16) -> Vector3<f64> {
        let Roles { other, other_at, .. } = self.roles;
        let Some(radius) = other.barrel else { return other_at.point(other.vertex(k)) };
        match ring_of(k) {
            Some((end, k)) => other_at.point(&other.ring_point(end, k, &self.rings[1])),
            None => other_at.point(other.vertex(k)) + self.side().unwrap_or_default().0 * radius,
        }
    }

    /// The vertices of O, world, m.
    fn visit_owner(&self, f: &mut impl FnMut(u16, Vector3<f64>)) {
        let Roles { owner, owner_at, face, .. } = self.roles;
        if owner.barrel.is_some() {
            (0..RING).for_each(|k| f(ring_vertex(face, k), self.vertex_of_owner(ring_vertex(face, k))));
        } else {
            owner.face(face).corners.iter().for_each(|&k| f(k, owner_at.point(owner.vertex(k))));
        }
    }

    fn vertex_of_owner(&self, k: u16) -> Vector3<f64> {
        let Roles { owner, owner_at, .. } = self.roles;
        match ring_of(k).filter(|_| owner.barrel.is_some()) {
            Some((end, k)) => owner_at.point(&owner.ring_point(end, k, &self.rings[0])),
            None => owner_at.point(owner.vertex(k)),
        }
    }

    /// d of a point inside O, m.
    fn inside_owner(&self, x: &Vector3<f64>) -> f64 {
        let Roles { owner, owner_at, face, .. } = self.roles;
        let local = owner_at.rotation.tr_mul(&(x - owner_at.position));
        match owner.barrel {
            Some(radius) => radius - owner.across(&(local - owner.vertex(face))).norm(),
            None => self.roles.inside_owner(&local),
        }
    }

    /// d of a point inside I, along m, m.
    fn inside_other(&self, x: &Vector3<f64>) -> f64 {
        let Roles { owner_at, other, other_at, .. } = self.roles;
        let Some(face) = self.incident else { return f64::NEG_INFINITY };
        match other.barrel {
            Some(radius) => {
                let local = other_at.rotation.tr_mul(&(x - other_at.position));
                radius - other.across(&(local - other.vertex(face))).norm()
            }
            None => {
                let (r, p) = self.roles.relative();
                self.roles.inside_incident(face, &r, &p, &owner_at.rotation.tr_mul(&(x - owner_at.position)))
            }
        }
    }

    /// A border of O by the number of its edge; `None` for half-spaces.
    fn owner_border(&self, edge: u16) -> Border {
        let Roles { owner, owner_at, face, .. } = self.roles;
        match owner.barrel {
            Some(radius) => Border::Circle { centre: owner_at.point(owner.vertex(face)), axis: self.m, radius },
            None => Border::edge(owner, owner_at, edge),
        }
    }

    fn other_border(&self, edge: u16) -> Border {
        let Roles { other, other_at, .. } = self.roles;
        match (other.barrel, self.incident, self.side()) {
            (Some(radius), Some(end), _) => {
                let (centre, axis) = (other_at.point(other.vertex(end)), other_at.rotation * other.axis());
                Border::Circle { centre, axis, radius }
            }
            (Some(radius), None, Some((u, _))) => {
                let (start, along) = (other_at.point(other.vertex(0)), other_at.rotation * other.axis());
                Border::Line { start: start + u * radius, along, length: other.edge(0).length }
            }
            _ => Border::edge(other, other_at, edge),
        }
    }

    /// Calls `f` with each pair of edges of O and I that can cross.
    fn visit_pairs(&self, f: &mut impl FnMut(u16, u16)) {
        let Roles { owner, face, other, .. } = self.roles;
        let of_other = |f: &mut dyn FnMut(u16)| match (other.barrel, self.incident) {
            (Some(_), Some(end)) => f(rim_edge(end, 0)),
            (None, Some(face)) => other.face(face).edges.iter().for_each(|&k| f(k)),
            (_, None) => (0..other.edges.len() as u16).for_each(f),
        };
        let of_owner = |f: &mut dyn FnMut(u16)| match owner.barrel {
            Some(_) => f(rim_edge(face, 0)),
            None => owner.face(face).edges.iter().for_each(|&k| f(k)),
        };
        of_owner(&mut |k| {
            of_other(&mut |l| match (owner.barrel, other.barrel.and(self.incident)) {
                (Some(_), _) => (0..2).for_each(|branch| f(k + branch, l)),
                (None, Some(_)) => (0..2).for_each(|branch| f(k, l + branch)),
                (None, None) => f(k, l),
            });
        });
    }

    /// The crossing of an edge of O and one of I.
    fn crossing(&self, k: u16, l: u16) -> Option<Crossing> {
        let (of_owner, of_other) = (self.owner_border(k), self.other_border(l));
        Crossing::new(&self.m, (&of_owner, side_of_rim(k)), (&of_other, side_of_rim(l)))
    }

    /// Position c, m, rate c', m/s, and gap, m, of a corner.
    pub fn corner(&self, corner: &Corner) -> (Vector3<f64>, Vector3<f64>, f64) {
        let Roles { owner_at, other, other_at, .. } = self.roles;
        let (m, r) = (&self.m, other.rounding);
        let m_rate = owner_at.omega.cross(m);
        let slip = self.slip();
        if let Some(k) = self.roles.incident_vertex(corner) {
            let x = self.vertex_of_other(k);
            // The points of a ring are fixed to the body.
            let slip = if other.barrel.is_some() && ring_of(k).is_some() { Vector3::zeros() } else { slip };
            return (x - m * r, other_at.velocity_at(&x) + slip - m_rate * r, self.height(&x) - r);
        }
        if let Some((k, l)) = self.roles.crossing(corner) {
            let none = Crossing { z: Vector3::zeros(), e: *m, q: *m, g: 0.0 };
            let Crossing { z, e, q, .. } = self.crossing(k, l).unwrap_or(none);
            let v = other_at.velocity_at(&z) + slip;
            let s_rate = -q.dot(&(v - owner_at.velocity_at(&z))) / q.dot(&e);
            return (z - m * r, v + e * s_rate - m_rate * r, self.height(&z) - r);
        }
        let w = self.vertex_of_owner(self.roles.owner_vertex(corner).unwrap_or(0));
        let gap = self.incident.map_or(0.0, |k| {
            let incident = other.face(k);
            let m_i = other_at.rotation * incident.normal;
            (incident.offset - m_i.dot(&(w - other_at.position))) / m_i.dot(m)
        });
        let c = w + m * gap;
        (c, owner_at.velocity_at(&c), gap)
    }

    /// R u'_I, m/s.
    fn slip(&self) -> Vector3<f64> {
        let Roles { owner_at, other, other_at, .. } = self.roles;
        let (Some((u, size)), Some(radius)) = (self.side(), other.barrel) else { return Vector3::zeros() };
        let t = (other_at.rotation * other.axis()).cross(&u);
        let turn = (owner_at.omega - other_at.omega).cross(&self.m);
        if size == 0.0 { Vector3::zeros() } else { t * (-radius * t.dot(&turn) / size) }
    }

    /// Chooses the end of I and the directions of rings, then the corners; see [`super::topology`].
    pub fn build(mut self, near: f64, present: Option<u16>, out: &mut Topology) -> bool {
        out.corners.clear();
        out.incident = None;
        let Roles { owner, other, is_owner_b, .. } = self.roles;
        if other.is_half_space() {
            return false;
        }
        if other.barrel.is_some() {
            self.choose_end(near, present);
        } else {
            let m = self.down();
            let height = |k: &u16| self.height(&self.roles.other_at.point(other.vertex(*k))) - other.rounding;
            self.incident = incident_face(&self.roles, &m, present, |k| height(k) <= near);
        }
        if owner.barrel.is_some() && self.rings[0] == Vector3::zeros() {
            self.rings[0] = owner.any_across();
        }
        let mut points = self.points();
        if points.is_empty() && self.turn_rings() {
            points = self.points();
        }
        let gap = |corner: &Corner| self.corner(corner).2;
        let is_near = points.iter().any(|point| gap(&point.corner) <= near);
        if points.len() > MAX_CORNERS {
            points.truncate(MAX_CORNERS);
        }
        if !is_owner_b {
            points.reverse();
        }
        out.corners.extend(points.iter().map(|point| point.corner));
        out.crossed = points.iter().rev().fold(0, |bits, point| bits << 1 | u64::from(point.is_crossed));
        out.incident = self.incident;
        let used = |body: &ConvexBody, ring: Vector3<f64>| if body.barrel.is_some() { ring } else { Vector3::zeros() };
        let rings = [used(owner, self.rings[0]), used(other, self.rings[1])];
        out.rings = if is_owner_b { [rings[1], rings[0]] } else { rings };
        is_near
    }

    /// Whether I touches with an end, and w.
    fn choose_end(&mut self, near: f64, present: Option<u16>) {
        let other = self.roles.other;
        let (down, radius) = (self.down(), other.barrel.unwrap_or(0.0));
        let across = other.across(&down);
        let tilt = across.norm();
        let end = u16::from(other.axis().dot(&down) < 0.0);
        let lowest = match self.rings[1] {
            _ if tilt > LEVEL => across / -tilt,
            w if w == Vector3::zeros() => other.any_across(),
            w => w,
        };
        let kept = present == Some(end) && self.rings[1] != Vector3::zeros();
        let ring = if kept { self.rings[1] } else { lowest };
        let below = radius * (tilt - other.along_ring(&-across, &ring));
        let is_level = tilt <= 1.001 * LANDED || 2.0 * radius * tilt <= near;
        let is_flat = is_level && below <= 0.5 * RESOLUTION;
        self.incident = is_flat.then_some(end);
        self.rings[1] = if is_flat { ring } else { lowest };
    }

    /// The corners, counter-clockwise about m, without equal ones.
    fn points(&self) -> Vec<Point> {
        let mut points = Vec::new();
        let roles = &self.roles;
        self.visit_other(&mut |k, x| {
            if self.inside_owner(&x) >= -RESOLUTION {
                points.push(Point { corner: roles.incident_corner(k), x, rank: 2, is_crossed: false });
            }
        });
        if self.has_inside() {
            self.visit_owner(&mut |k, x| {
                if self.inside_other(&x) >= -RESOLUTION {
                    points.push(Point { corner: roles.owner_corner(k), x, rank: 1, is_crossed: false });
                }
            });
        }
        self.visit_pairs(&mut |k, l| {
            if let Some(Crossing { z, g, .. }) = self.crossing(k, l)
                && g > 0.0
            {
                points.push(Point { corner: roles.crossing_corner(k, l), x: z, rank: 0, is_crossed: false });
            }
        });
        let (m, first) = (self.m, m_across(&self.m));
        let second = m.cross(&first);
        let flat = |v: &Vector3<f64>| v - m * m.dot(v);
        points.sort_by_key(|point| std::cmp::Reverse(point.rank));
        let mut kept: Vec<Point> = Vec::with_capacity(points.len());
        for point in points {
            match kept.iter_mut().find(|other| flat(&(other.x - point.x)).norm() <= RESOLUTION) {
                Some(other) => other.is_crossed |= other.rank > 0 && point.rank == 0,
                None => kept.push(point),
            }
        }
        let mean = kept.iter().map(|point| point.x).sum::<Vector3<f64>>() / kept.len().max(1) as f64;
        let angle = |point: &Point| {
            let x = point.x - mean;
            diamond(first.dot(&x), second.dot(&x))
        };
        kept.sort_by(|s, t| angle(s).total_cmp(&angle(t)));
        kept
    }

    /// Functions of the validity; see the module.
    pub fn visit(&self, topology: &Topology, f: &mut impl FnMut(f64)) {
        let Roles { owner, other, other_at, .. } = self.roles;
        let signed = |is_corner: bool, value: f64| if is_corner { value } else { -value };
        let is_in = |corner: Corner| topology.corners.contains(&corner);
        let vertex = |f: &mut dyn FnMut(f64), corner: Corner, inside: f64| {
            let at = topology.corners.iter().position(|other| *other == corner);
            f(signed(at.is_some(), inside));
            if at.is_some_and(|c| topology.crossed >> c & 1 == 1) {
                f(-inside);
            }
        };
        if let Some(radius) = other.barrel {
            let across = other.across(&self.down());
            let tilt = across.norm();
            if self.incident.is_some() {
                f(radius * (other.along_ring(&-across, &self.rings[1]) - tilt));
                f(radius * (TIPPED - tilt));
            } else {
                let turned = -across.dot(&self.rings[1]) - 0.5 * tilt;
                f(radius * turned.max(tilt - STEEP));
                f(radius * (tilt - LANDED));
            }
        } else if let Some(face) = self.incident {
            let corners = &other.face(face).corners;
            for (k, x) in other.vertices.iter().enumerate() {
                if !corners.contains(&(k as u16)) {
                    f(self.height(&other_at.point(x)));
                }
            }
        }
        if !owner.is_half_space() {
            self.visit_other(&mut |k, x| {
                let corner = self.roles.incident_corner(k);
                vertex(f, corner, self.inside_owner(&x));
                if self.incident.is_some() && !is_in(corner) {
                    f(self.height(&x) - other.rounding + DIPPED);
                }
            });
        }
        if self.incident.is_some() {
            self.visit_owner(&mut |k, x| vertex(f, self.roles.owner_corner(k), self.inside_other(&x)));
        }
        self.visit_pairs(&mut |k, l| {
            let g = self.crossing(k, l).map_or(f64::NEG_INFINITY, |crossing| crossing.g);
            f(signed(is_in(self.roles.crossing_corner(k, l)), g));
        });
    }
}

/// Some unit vector across `m`.
fn m_across(m: &Vector3<f64>) -> Vector3<f64> {
    m.cross(&Vector3::ith(m.iamin(), 1.0)).normalize()
}

/// Grows with the angle of (x, y), from 0 to 4.
fn diamond(x: f64, y: f64) -> f64 {
    let size = x.abs() + y.abs();
    if size == 0.0 {
        0.0
    } else if y >= 0.0 {
        1.0 - x / size
    } else {
        3.0 + x / size
    }
}
