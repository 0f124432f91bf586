//! The support mapping of a polyhedron in a pose, in two forms: with transformed vertices, which is
//! faster when many pairs query them, or with directions rotated into its own frame, which needs no
//! preparation.

use nalgebra::Vector3;

use crate::collision::kinematics::LinkPose;
use crate::collision::spatial::Polytope;

/// Queries of the algorithms on a body, all in the frame shared by the bodies.
pub trait SupportMapping {
    /// The outermost vertex in direction `d`, beginning the search at `start`.
    fn outermost(&self, d: &Vector3<f64>, start: u16) -> u16;

    /// Position of a vertex, m.
    fn vertex(&self, k: u16) -> Vector3<f64>;
}

/// A polyhedron with transformed vertices.
#[derive(Clone, Copy)]
pub struct TransformedPolytope<'a> {
    /// The polyhedron.
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

/// A polyhedron with a pose.
#[derive(Clone, Copy)]
pub struct PosedPolytope<'a> {
    /// The polyhedron.
    pub polytope: &'a Polytope,
    /// Pose of its frame in the shared one.
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
