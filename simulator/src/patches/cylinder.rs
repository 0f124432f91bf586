//! Cylinders with flat ends.
//!
//! The core is the axis, a segment from c_0 to c_1 with the direction a; R is the radius. With the
//! part P x = x - (a . x) a of a vector across the axis, the points that are lowest along n are
//!
//! ```text
//! n not along a      rim point of an end k:   c_k + R u,   u = -P n / |P n|
//! n across a         those of both ends, and the generator between them
//! n = -+a            all of the end
//! ```
//!
//! A plane that touches an end flat has as corners `RING` points on the rim, a regular polygon. Its
//! first point has the direction w, which a topology keeps. Between two points the polygon is inside
//! the rim by up to R (1 - cos(pi/`RING`)), 1.9 % of R. More corners would make each choice of states
//! longer (a polygon has 4 `RING` + 3 states). When the load reaches a side between two points, the ring
//! turns so that a point is there ([`super::turn_ring`]): the rim, not the polygon, decides when a cylinder tips.
//!
//! Numbers of features: vertices 0 and 1 are the rim points of the ends 0 and 1, the points of the
//! rings follow. Edge 0 is the generator; each end has two further numbers of edges, for the two
//! points in which its rim crosses a line or another rim.

use super::{ConvexBody, Edge, Face, Feature};
use crate::math;
use nalgebra::{Isometry3, Vector3};

/// Number of corners of a flat end.
pub const RING: usize = 16;

/// Number of the first point of a ring.
const FIRST: u16 = 2;

impl ConvexBody {
    /// A cylinder with flat ends along the z axis, around the origin. `half_length` and `radius`: m.
    pub fn cylinder(half_length: f64, radius: f64) -> Self {
        let end = |sign: f64| Face {
            corners: vec![],
            normal: Vector3::z() * sign,
            offset: half_length,
            edges: vec![],
            touchable: true,
        };
        ConvexBody {
            faces: vec![end(-1.0), end(1.0)],
            rounding: 0.0,
            barrel: Some(radius),
            radius: (half_length * half_length + radius * radius).sqrt(),
            inner: half_length.min(radius),
            ..Self::capsule(half_length, radius)
        }
    }

    /// The body moved in its frame by `pose`, m.
    pub fn placed(mut self, pose: &Isometry3<f64>) -> Self {
        let turn = |v: &Vector3<f64>| pose.rotation * v;
        let shift = |v: &Vector3<f64>| pose.rotation * v + pose.translation.vector;
        self.vertices.iter_mut().for_each(|v| *v = shift(v));
        for face in &mut self.faces {
            face.normal = turn(&face.normal);
            face.offset += face.normal.dot(&pose.translation.vector);
        }
        for Edge { direction, inward, .. } in &mut self.edges {
            *direction = turn(direction);
            *inward = inward.map(|u| turn(&u));
        }
        self.centre = shift(&self.centre);
        self
    }

    /// Direction a of the axis of a cylinder or capsule, body frame.
    pub fn axis(&self) -> &Vector3<f64> {
        &self.edges[0].direction
    }

    /// Rounding of an edge, m: the radius for the axis of a cylinder.
    pub fn edge_rounding(&self) -> f64 {
        self.barrel.unwrap_or(self.rounding)
    }

    /// Rounding of a feature, m.
    pub fn feature_rounding(&self, feature: Feature) -> f64 {
        match feature {
            Feature::Rim(_) => 0.0,
            Feature::Edge(_) => self.edge_rounding(),
            Feature::Vertex(_) => self.rounding,
        }
    }

    /// Whether two points can touch along an edge of it: a rounded body or a cylinder.
    pub fn is_round(&self) -> bool {
        self.edge_rounding() > 0.0
    }

    /// The part of a vector across the axis, body frame.
    pub(super) fn across(&self, v: &Vector3<f64>) -> Vector3<f64> {
        v - self.axis() * self.axis().dot(v)
    }

    /// Some unit vector across the axis, body frame.
    pub(super) fn any_across(&self) -> Vector3<f64> {
        self.across(&Vector3::ith(self.axis().iamin(), 1.0)).normalize()
    }

    /// A point of the ring of an end, body frame, m; `first`: direction w of the first.
    pub(super) fn ring_point(&self, end: u16, k: usize, first: &Vector3<f64>) -> Vector3<f64> {
        let (sin, cos) = math::sin_cos(std::f64::consts::TAU * (k % RING) as f64 / RING as f64);
        let radius = self.barrel.unwrap_or(0.0);
        self.vertex(end) + (first * cos + self.axis().cross(first) * sin) * radius
    }

    /// Greatest of v . w_k over the directions w_k of the points of a ring, for v across the axis.
    pub(super) fn along_ring(&self, v: &Vector3<f64>, first: &Vector3<f64>) -> f64 {
        let centre = self.vertex(0);
        let radius = self.barrel.unwrap_or(1.0);
        let along = |k: usize| v.dot(&(self.ring_point(0, k, first) - centre)) / radius;
        (0..RING).map(along).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Distance of the sides of a ring from the axis, per radius.
pub(super) fn shortest() -> f64 {
    math::cos(std::f64::consts::PI / RING as f64)
}

/// Number of the vertex that is point `k` of the ring of an end.
pub(super) fn ring_vertex(end: u16, k: usize) -> u16 {
    FIRST + end * RING as u16 + k as u16
}

/// End and point of a ring of a vertex; `None` for rim points of the ends.
pub(super) fn ring_of(vertex: u16) -> Option<(u16, usize)> {
    let k = vertex.checked_sub(FIRST)?;
    Some((k / RING as u16, k as usize % RING))
}

/// Number of the edge for crossings with the rim of an end; `branch` 0 or 1.
pub(super) fn rim_edge(end: u16, branch: u16) -> u16 {
    1 + 2 * end + branch
}

/// Sign that chooses the branch of a rim's edge.
pub(super) fn side_of_rim(edge: u16) -> f64 {
    if edge % 2 == 1 { -1.0 } else { 1.0 }
}

/// The feature of a cylinder with this number of an edge.
pub(super) fn edge_feature(body: &ConvexBody, edge: u16) -> Feature {
    if body.barrel.is_some() && edge > 0 { Feature::Rim((edge - 1) / 2) } else { Feature::Edge(edge) }
}
