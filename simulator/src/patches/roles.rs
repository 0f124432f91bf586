//! The two bodies of a pair by their roles, for owners that are faces.

use super::{ConvexBody, Corner, Owner, Placement};
use nalgebra::{Matrix3, Vector3};

/// A body and its placement.
pub(super) type Placed<'a> = (&'a ConvexBody, &'a Placement);

/// Cosine between the incident face and the plane below which the face is upright and has no inside.
pub(super) const UPRIGHT: f64 = 1e-6;

/// Difference of cosines up to which faces are equally opposed to the owner's.
const EQUAL: f64 = 1e-9;

/// Owner of the face and the other (incident) body.
#[derive(Clone, Copy)]
pub(super) struct Roles<'a> {
    pub owner: &'a ConvexBody,
    pub owner_at: &'a Placement,
    /// Face of the owner.
    pub face: u16,
    pub other: &'a ConvexBody,
    pub other_at: &'a Placement,
    /// Whether the owner is B.
    pub is_owner_b: bool,
}

impl<'a> Roles<'a> {
    /// `None` for owners that are not faces.
    pub fn new(
        owner: Owner,
        a: &'a ConvexBody,
        pa: &'a Placement,
        b: &'a ConvexBody,
        pb: &'a Placement,
    ) -> Option<Self> {
        match owner {
            Owner::FaceOfA(face) => {
                Some(Roles { owner: a, owner_at: pa, face, other: b, other_at: pb, is_owner_b: false })
            }
            Owner::FaceOfB(face) => {
                Some(Roles { owner: b, owner_at: pb, face, other: a, other_at: pa, is_owner_b: true })
            }
            _ => None,
        }
    }

    /// Owner frame from the frame of the other body: rotation and position, m.
    pub fn relative(&self) -> (Matrix3<f64>, Vector3<f64>) {
        relative(self.owner_at, self.other_at)
    }

    /// Index of a corner that is a vertex of the other body.
    pub fn incident_vertex(&self, corner: &Corner) -> Option<u16> {
        match *corner {
            Corner::A(k) if self.is_owner_b => Some(k),
            Corner::B(k) if !self.is_owner_b => Some(k),
            _ => None,
        }
    }

    /// Index of a corner that is a vertex of the owner.
    pub fn owner_vertex(&self, corner: &Corner) -> Option<u16> {
        match *corner {
            Corner::B(k) if self.is_owner_b => Some(k),
            Corner::A(k) if !self.is_owner_b => Some(k),
            _ => None,
        }
    }

    /// Edge of the owner and edge of the other body of a corner that is a crossing.
    pub fn crossing(&self, corner: &Corner) -> Option<(u16, u16)> {
        match *corner {
            Corner::Crossing { a, b } if self.is_owner_b => Some((b, a)),
            Corner::Crossing { a, b } => Some((a, b)),
            _ => None,
        }
    }

    /// The corner that is the vertex `k` of the other body.
    pub fn incident_corner(&self, k: u16) -> Corner {
        if self.is_owner_b { Corner::A(k) } else { Corner::B(k) }
    }

    /// The corner that is the vertex `k` of the owner.
    pub fn owner_corner(&self, k: u16) -> Corner {
        if self.is_owner_b { Corner::B(k) } else { Corner::A(k) }
    }

    /// The crossing of an edge of the owner and an edge of the other body.
    pub fn crossing_corner(&self, owner: u16, other: u16) -> Corner {
        if self.is_owner_b { Corner::Crossing { a: other, b: owner } } else { Corner::Crossing { a: owner, b: other } }
    }

    /// Least distance, m, of the point `x`, owner frame, from the sides of the owner's face, positive
    /// inside; infinite without sides.
    pub fn inside_owner(&self, x: &Vector3<f64>) -> f64 {
        let corners = &self.owner.face(self.face).corners;
        let distance = |(k, &c): (usize, &u16)| self.owner.side_inward(self.face, k).dot(&(x - self.owner.vertex(c)));
        corners.iter().enumerate().map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Least distance, m, of the point `x`, owner frame, from the sides of a face of the other body,
    /// projected along the owner's normal m, positive inside. `r`, `p`: owner frame from the other's.
    pub fn inside_incident(&self, face: u16, r: &Matrix3<f64>, p: &Vector3<f64>, x: &Vector3<f64>) -> f64 {
        // In the frame of the other body. The face is counter-clockwise about its own normal, which
        // is opposite to m, so the way inside from a side e is e x m.
        let m = r.tr_mul(&self.owner.face(self.face).normal);
        let x = r.tr_mul(&(x - p));
        let ring = &self.other.face(face).corners;
        let distance = |(k, &c): (usize, &u16)| {
            let from = self.other.vertex(c);
            let along = self.other.vertex(ring[(k + 1) % ring.len()]) - from;
            let inward = along.cross(&m);
            let norm = inward.norm();
            if norm > super::RESOLUTION { inward.dot(&(x - from)) / norm } else { f64::INFINITY }
        };
        ring.iter().enumerate().map(distance).fold(f64::INFINITY, f64::min)
    }
}

/// The incident face: of the faces with the lowest vertex that are turned to the owner, those with
/// the most near corners; of these the most opposed; of equally opposed ones `present`, or the
/// first. On sharp ridges the most opposed face of all need not have the lowest vertex. `m`: normal
/// of the owner in the frame of the other body.
pub(super) fn incident_face(
    roles: &Roles,
    m: &Vector3<f64>,
    present: Option<u16>,
    is_near: impl Fn(&u16) -> bool,
) -> Option<u16> {
    let (faces, vertices) = (&roles.other.faces, &roles.other.vertices);
    let height = |k: usize| m.dot(&vertices[k]);
    let lowest = (0..vertices.len()).min_by(|&i, &j| height(i).total_cmp(&height(j)))? as u16;
    let slope = |k: u16| m.dot(&faces[k as usize].normal);
    let may_touch = |&k: &u16| slope(k) <= EQUAL && faces[k as usize].corners.contains(&lowest);
    let count = |k: u16| faces[k as usize].corners.iter().filter(|&c| is_near(c)).count();
    let all = || (0..faces.len() as u16).filter(may_touch);
    let most = all().map(count).max()?;
    let candidates = || all().filter(|&k| count(k) == most);
    let least = candidates().map(slope).fold(f64::INFINITY, f64::min);
    let opposed = |&k: &u16| slope(k) <= least + EQUAL;
    candidates().filter(opposed).find(|&k| Some(k) == present).or_else(|| candidates().find(opposed))
}

/// Frame of `to` from the frame of `from`: rotation and position, m.
pub(super) fn relative(to: &Placement, from: &Placement) -> (Matrix3<f64>, Vector3<f64>) {
    let r = to.rotation.transpose() * from.rotation;
    (r, to.rotation.tr_mul(&(from.position - to.position)))
}
