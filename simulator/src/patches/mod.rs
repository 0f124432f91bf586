//! Contact patches between two convex bodies that touch along one common supporting plane.
//!
//! Bodies A and B, of which both may move, touch in a convex polygon, a segment or a point. All of
//! these lie in one plane with the normal n, which points from B into A. The owner of the plane is
//! the feature, or the pair of features, that defines n:
//!
//! ```text
//! FaceOfB(f)   n =  R_B n_f               all corners of A are above the face
//! FaceOfA(f)   n = -R_A n_f               all corners of B are below the face
//! Edges(a, b)  n = +-(e_A x e_B)/|e_A x e_B|
//! Along(a, b)  n = mean of the directions between nearest points at the ends of parallel edges
//! others       n = (c_A - c_B)/|c_A - c_B|  nearest points of the cores
//! ```
//!
//! The others need a rounded body, or a cylinder: its rims are curved edges.
//!
//! - `body`, `hull`, `cylinder`: bodies with their features, in body frames.
//! - `separation`: signed separation of a pair, and the owner of its plane.
//! - `clipping`: the topology of a patch: which features are its corners.
//! - `flat`, `borders`: the same, and the kinematics, of cylinders on faces.
//! - `parallel`: patches of parallel edges of which one is round.
//! - `curves`: nearest points of the rims of cylinders.
//! - `pins`: nearest points of vertices and edges.
//! - `kinematics`: axes, positions, gaps, velocities and bias accelerations of a held topology.
//! - `validity`: a continuous function that is positive while the topology holds.
//! - `ring_turn`: turns of the polygons on ends of cylinders.
//! - `ties`: other owners of the same separation.
//! - `reowner`: changes of the owner when only some corners stay in contact.
//!
//! Queries of `parry3d` do not take the place of these: version 0.31 gives distances of boxes and hulls to 3e-16 m, but
//! of cylinders to 1.6e-9 m (20000 random poses 0 to 1 mm above a box), and none tells the features that own the plane.
//! Corners, plane and validity follow the motion of these between events. Pieces of terrain also need to know which of
//! their faces others cover.
//!
//! Units: m, s, rad.
//!
//! Imports: `math`. Used by: `sim`, `assemble`.

pub mod body;
mod borders;
pub mod clipping;
mod curves;
pub mod cylinder;
mod flat;
pub mod hull;
pub mod kinematics;
mod parallel;
mod pins;
pub mod reowner;
mod ring_turn;
mod roles;
pub mod separation;
#[cfg(test)]
mod tests;
mod ties;
pub mod validity;

pub use body::{ConvexBody, Edge, Face};
pub use clipping::topology;
pub use cylinder::RING;
pub use kinematics::geometry;
pub use reowner::reowner;
pub use ring_turn::turn_ring;
pub use separation::{Separation, separation, touchable_depth};
pub use ties::{flat_topology, tied_topology};
pub use validity::validity;

use nalgebra::{Matrix3, Vector3};

/// Depth, m, up to which a plane separates bodies that touch along it.
pub const SEPARATES: f64 = 1e-6;

/// Distance, m, below which corners are one, and up to which a vertex lies on a border.
pub const RESOLUTION: f64 = 1e-9;

/// Greatest number of corners of a patch.
pub const MAX_CORNERS: usize = 64;

/// Pose and velocity of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// World from body axes.
    pub rotation: Matrix3<f64>,
    /// Origin of the body frame, world, m.
    pub position: Vector3<f64>,
    /// Velocity of the origin of the body frame, world, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, world, rad/s.
    pub omega: Vector3<f64>,
}

impl Placement {
    /// A body at rest. `rotation`: world from body; `position`: world, m.
    pub fn at_rest(rotation: Matrix3<f64>, position: Vector3<f64>) -> Self {
        Placement { rotation, position, velocity: Vector3::zeros(), omega: Vector3::zeros() }
    }

    /// World position, m, of a point given in the body frame, m.
    pub fn point(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * v
    }

    /// Bound of the way of the points of a body from its placement `start` to this one, m:
    /// `|c - c_0| + r |R - R_0|` with the centre c and the radius r of its sphere and the Frobenius norm.
    pub fn way_from(&self, start: &Placement, body: &ConvexBody) -> f64 {
        self.way_with_turn(start, self.turn_from(start), body)
    }

    /// `|R - R_0|` of [`way_from`](Self::way_from), which bodies of one link have in common.
    pub fn turn_from(&self, start: &Placement) -> f64 {
        (self.rotation - start.rotation).norm()
    }

    /// [`way_from`](Self::way_from) for a known [`turn_from`](Self::turn_from).
    pub fn way_with_turn(&self, start: &Placement, turn: f64, body: &ConvexBody) -> f64 {
        let shift = (self.point(&body.centre) - start.point(&body.centre)).norm();
        shift + if turn > 0.0 { turn * body.radius } else { 0.0 }
    }

    /// Velocity of the centre of a body, world, m/s, and a bound of that of its points relative to it, m/s; zero for
    /// half-spaces, which have no farthest point.
    pub fn speeds(&self, body: &ConvexBody) -> (Vector3<f64>, f64) {
        let turn = if body.is_half_space() { 0.0 } else { self.omega.norm() * body.radius };
        (self.velocity_at(&self.point(&body.centre)), turn)
    }

    /// Velocity, world, m/s, of the material point of the body at the world position `x`, m.
    pub fn velocity_at(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.omega.cross(&(x - self.position))
    }
}

/// The feature or pair of features that defines the plane of contact. Indices of features of A come
/// before those of B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// Face of A; n is opposite to its outward normal.
    FaceOfA(u16),
    /// Face of B; n is its outward normal.
    FaceOfB(u16),
    /// Edge of A and edge of B that cross.
    Edges(u16, u16),
    /// Vertex of A and vertex of B, one of them rounded.
    VertexVertex(u16, u16),
    /// Vertex of A and edge of B, one of them rounded.
    VertexOfAEdgeOfB(u16, u16),
    /// Edge of A and vertex of B, one of them rounded.
    EdgeOfAVertexOfB(u16, u16),
    /// Features of A and B, of which at least one is the rim of a cylinder.
    Curved(Feature, Feature),
    /// Parallel edges of A and B, one of them rounded or the side of a cylinder.
    Along(u16, u16),
}

impl Owner {
    /// The features of A and B that define the plane; `None` for faces.
    pub fn features(self) -> Option<(Feature, Feature)> {
        match self {
            Owner::FaceOfA(_) | Owner::FaceOfB(_) => None,
            Owner::Edges(i, j) | Owner::Along(i, j) => Some((Feature::Edge(i), Feature::Edge(j))),
            Owner::VertexVertex(i, j) => Some((Feature::Vertex(i), Feature::Vertex(j))),
            Owner::VertexOfAEdgeOfB(i, j) => Some((Feature::Vertex(i), Feature::Edge(j))),
            Owner::EdgeOfAVertexOfB(i, j) => Some((Feature::Edge(i), Feature::Vertex(j))),
            Owner::Curved(of_a, of_b) => Some((of_a, of_b)),
        }
    }
}

/// A feature of a body with its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Vertex.
    Vertex(u16),
    /// Edge; number 0 of a cylinder is its side.
    Edge(u16),
    /// Rim of an end of a cylinder.
    Rim(u16),
}

/// A corner of a patch by the features that define it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Vertex of A.
    A(u16),
    /// Vertex of B.
    B(u16),
    /// Crossing of two edges.
    Crossing {
        /// Edge of A.
        a: u16,
        /// Edge of B.
        b: u16,
    },
}

/// Topology of a patch; it persists from step to step until `validity` reaches zero.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Definition of the plane.
    pub owner: Owner,
    /// For owners that are faces: the face of the other body; `None` for bodies without faces, and for
    /// cylinders that touch with their side or a point of a rim.
    pub incident: Option<u16>,
    /// Corners, counter-clockwise about n.
    pub corners: Vec<Corner>,
    /// Sign of e_A x e_B along n, for edge pairs.
    sign: f64,
    /// Axis of A's body frame from which the tangents are built, for vertex pairs.
    axis: u8,
    /// Directions w of the first points of the rings of A and B, in their frames; see `cylinder`.
    rings: [Vector3<f64>; 2],
    /// A bit for each corner that is a vertex on the border of a cylinder, or of what touches one, with a crossing in
    /// its place: the crossing appears when the vertex moves inside.
    crossed: u64,
    /// Added to the functions of `validity`, in their order, so that none is zero at the start, m.
    offsets: Vec<f64>,
}

impl Topology {
    /// An empty topology, with room for the greatest patch.
    pub fn new() -> Self {
        Topology {
            owner: Owner::FaceOfB(0),
            incident: None,
            corners: Vec::with_capacity(MAX_CORNERS),
            sign: 1.0,
            axis: 0,
            rings: [Vector3::zeros(); 2],
            crossed: 0,
            offsets: Vec::new(),
        }
    }

    /// Whether no function of its validity was less than -`depth`, m, when it was made: its plane separated the
    /// bodies.
    pub fn separates(&self, depth: f64) -> bool {
        self.offsets.iter().all(|offset| *offset <= RESOLUTION + depth)
    }

    /// Whether points of A or B roll on the other, so that no point of them is fixed to both.
    pub fn rolls(&self, a: &ConvexBody, b: &ConvexBody) -> bool {
        let is_round = |body: &ConvexBody| body.rounding > 0.0;
        is_round(a)
            || is_round(b)
            || match self.owner {
                Owner::FaceOfA(_) => b.barrel.is_some() && self.incident.is_none(),
                Owner::FaceOfB(_) => a.barrel.is_some() && self.incident.is_none(),
                _ => a.barrel.is_some() || b.barrel.is_some(),
            }
    }

    /// Whether corners with the same numbers are the same points of the bodies as those of `other`.
    pub fn has_rings_of(&self, other: &Topology) -> bool {
        self.rings == other.rings
    }
}

impl Default for Topology {
    fn default() -> Self {
        Self::new()
    }
}

/// Axes and corners of a patch at one configuration.
#[derive(Clone, Debug)]
pub struct PatchGeometry {
    /// World from patch axes. Column 2 is n, from B into A. Column 0 is fixed to the owner.
    pub axes: Matrix3<f64>,
    /// One entry per corner of the topology, in its order.
    pub points: Vec<CornerMotion>,
}

impl PatchGeometry {
    /// No corners, with room for the greatest patch.
    pub fn new() -> Self {
        PatchGeometry { axes: Matrix3::identity(), points: Vec::with_capacity(MAX_CORNERS) }
    }
}

impl Default for PatchGeometry {
    fn default() -> Self {
        Self::new()
    }
}

/// Position and relative motion at a corner of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerMotion {
    /// World, m.
    pub position: Vector3<f64>,
    /// Distance along n, m.
    pub gap: f64,
    /// Part of the relative acceleration that does not depend on the accelerations of the bodies,
    /// world, m/s^2.
    pub bias: Vector3<f64>,
    /// Velocity of the material point of A minus that of B, world, m/s.
    pub velocity: Vector3<f64>,
    /// Rate of the normal n at this corner, world, 1/s.
    pub normal_rate: Vector3<f64>,
}
