//! End effectors of the robot file.

use super::AugmentedData;
use crate::dynamics::{Motion, jacobian};
use crate::robot::Model;
use nalgebra::Isometry3;

/// One end effector. World axes.
#[derive(Clone, Debug)]
pub struct EndEffectorData {
    /// Pose of its frame.
    pub pose: Isometry3<f64>,
    /// Velocity of its origin, m/s, and angular velocity, rad/s.
    pub twist: Motion,
    /// `(p', omega) = J v` of its origin, 6 x nv.
    pub jacobian: Vec<f64>,
}

impl EndEffectorData {
    pub(super) fn new(nv: usize) -> Self {
        EndEffectorData { pose: Isometry3::identity(), twist: Motion::ZERO, jacobian: vec![0.0; 6 * nv] }
    }
}

impl AugmentedData {
    pub(super) fn find_end_effectors(&mut self, model: &Model) {
        for (i, effector) in model.end_effectors.iter().enumerate() {
            let pose = self.frame_pose(effector.link, &effector.pose);
            let at = pose.translation.vector;
            let data = &mut self.end_effectors[i];
            data.pose = pose;
            data.twist = jacobian::link_twist(&self.workspace, effector.link, &at);
            jacobian::frame(&self.workspace, effector.link, &at, &mut data.jacobian);
        }
    }
}
