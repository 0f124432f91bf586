//! Poses, velocities and Jacobians of links and of frames fixed in them.

use super::AugmentedData;
use crate::dynamics::{Motion, jacobian};
use crate::robot::{LinkId, Model};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

impl AugmentedData {
    /// Pose in the world of the link's URDF frame. Needs [`super::Needs::LINKS`] or any other part.
    pub fn link_pose(&self, model: &Model, link: LinkId) -> Isometry3<f64> {
        self.frame_pose(link, &model.links[link.0].urdf_frame)
    }

    /// Pose in the world of a frame in the link's internal frame, such as that of [`Model::link`]
    /// for a welded link.
    pub fn frame_pose(&self, link: LinkId, frame: &Isometry3<f64>) -> Isometry3<f64> {
        let at = &self.workspace.links[link.0];
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(at.rotation));
        Isometry3::from_parts(Translation3::from(self.workspace.position + at.origin), turn) * frame
    }

    /// Velocity of the link's point that is at the world point `point`, m/s, and the link's
    /// angular velocity, rad/s.
    pub fn twist(&self, link: LinkId, point: &Vector3<f64>) -> Motion {
        jacobian::link_twist(&self.workspace, link, point)
    }

    /// Jacobian of the frame fixed in the link whose origin is at the world point `point`:
    /// `(p', omega) = J v`, 6 x nv, into `out`.
    pub fn jacobian(&self, link: LinkId, point: &Vector3<f64>, out: &mut [f64]) {
        jacobian::frame(&self.workspace, link, point, out);
    }
}
