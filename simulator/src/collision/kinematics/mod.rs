//! Poses of the links, and extrapolated joint positions.

mod extrapolate;
mod link_poses;

pub(crate) use extrapolate::capped_travel;
pub use extrapolate::extrapolate;
pub(crate) use link_poses::link_pose;
pub use link_poses::{LinkPose, link_poses};
