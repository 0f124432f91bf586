//! The bodies in one posture.

use nalgebra::Vector3;

use super::axis_box::AxisBox;
use super::support_mapping::{PosedPolytope, TransformedPolytope};
use crate::collision::kinematics::LinkPose;
use crate::collision::spatial::Body;

/// Poses, boxes and vertices of all bodies in one posture.
#[derive(Clone, Debug)]
pub struct PosedBodies {
    poses: Vec<LinkPose>,
    boxes: Vec<AxisBox>,
    /// Vertices of all bodies one after the other.
    points: Vec<Vector3<f64>>,
    /// The vertices of body i are `points[first[i]..first[i + 1]]`.
    first: Vec<usize>,
}

impl PosedBodies {
    /// For these bodies.
    pub fn new(bodies: &[Body]) -> Self {
        let mut first = vec![0];
        first.extend(bodies.iter().scan(0, |sum, b| {
            *sum += b.polytope.vertices.len();
            Some(*sum)
        }));
        let n = bodies.len();
        Self {
            poses: vec![LinkPose::IDENTITY; n],
            boxes: vec![AxisBox::ORIGIN; n],
            points: vec![Vector3::zeros(); first[n]],
            first,
        }
    }

    /// Moves all bodies; `poses` has one entry per link.
    pub fn set_poses(&mut self, bodies: &[Body], poses: &[LinkPose]) {
        for i in 0..bodies.len() {
            self.set_body_pose(bodies, i, poses);
        }
    }

    /// Moves one body.
    #[inline]
    pub fn set_body_pose(&mut self, bodies: &[Body], i: usize, poses: &[LinkPose]) {
        self.poses[i] = poses[bodies[i].link.0];
        self.boxes[i] = AxisBox::around(&bodies[i].polytope.bounds, &self.poses[i]);
    }

    /// Squared distance of two bodies' boxes, m^2: a lower bound of that of the bodies.
    #[inline]
    pub fn gap_squared(&self, [i, k]: [usize; 2]) -> f32 {
        self.boxes[i].gap_squared(&self.boxes[k])
    }

    /// Two bodies represented by their poses.
    #[inline]
    pub fn posed<'a>(&'a self, bodies: &'a [Body], pair: [usize; 2]) -> [PosedPolytope<'a>; 2] {
        pair.map(|i| PosedPolytope { polytope: &bodies[i].polytope, pose: &self.poses[i] })
    }

    /// Two bodies represented by their transformed vertices. Needs [`Self::transform_vertices`].
    #[inline]
    pub fn transformed<'a>(&'a self, bodies: &'a [Body], pair: [usize; 2]) -> [TransformedPolytope<'a>; 2] {
        pair.map(|i| TransformedPolytope {
            polytope: &bodies[i].polytope,
            points: &self.points[self.first[i]..self.first[i + 1]],
        })
    }

    /// Transforms the vertices of all bodies.
    pub fn transform_vertices(&mut self, bodies: &[Body]) {
        for (i, body) in bodies.iter().enumerate() {
            let pose = self.poses[i];
            let points = &mut self.points[self.first[i]..self.first[i + 1]];
            for (to, from) in points.iter_mut().zip(&body.polytope.vertices) {
                *to = pose.point(from);
            }
        }
    }
}
