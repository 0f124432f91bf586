//! A polyhedron in its place, in one of two ways: with its vertices moved there, which pays when many pairs ask for them, or
//! with directions turned back into its own frame, which costs nothing beforehand.

use nalgebra::Vector3;

use crate::collision::kinematics::LinkPose;
use crate::collision::spatial::Polytope;

/// What an algorithm asks of a body; everything in the frame shared by the bodies.
pub trait SupportMapping {
    /// The outermost vertex in direction `d`, beginning the search at `start`.
    fn outermost(&self, d: &Vector3<f64>, start: u16) -> u16;

    /// The place of a vertex, m.
    fn vertex(&self, k: u16) -> Vector3<f64>;
}

/// With moved vertices.
#[derive(Clone, Copy)]
pub struct TransformedPolytope<'a> {
    /// What it is.
    pub polytope: &'a Polytope,
    /// Its vertices in the shared frame, m.
    pub points: &'a [Vector3<f64>],
}

impl SupportMapping for TransformedPolytope<'_> {
    #[inline]
    fn outermost(&self, d: &Vector3<f64>, start: u16) -> u16 {
        self.polytope.support(self.points, d, start)
    }

    #[inline]
    fn vertex(&self, k: u16) -> Vector3<f64> {
        self.points[k as usize]
    }
}

/// With a pose.
#[derive(Clone, Copy)]
pub struct PosedPolytope<'a> {
    /// What it is.
    pub polytope: &'a Polytope,
    /// Of its frame in the shared one.
    pub pose: &'a LinkPose,
}

impl SupportMapping for PosedPolytope<'_> {
    #[inline]
    fn outermost(&self, d: &Vector3<f64>, start: u16) -> u16 {
        self.polytope.support(&self.polytope.vertices, &self.pose.rotation.tr_mul(d), start)
    }

    #[inline]
    fn vertex(&self, k: u16) -> Vector3<f64> {
        self.pose.point(&self.polytope.vertices[k as usize])
    }
}
