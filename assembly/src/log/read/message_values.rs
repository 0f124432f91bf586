//! Vectors and quaternions of log messages as `nalgebra` types.

use crate::log::messages;
use foxglove::messages::FrameTransform;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// A vector.
pub(super) fn vector(v: &messages::Vector3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// A vector that other protobuf writers may omit when it is zero.
pub(super) fn vector_or_zero(v: &Option<messages::Vector3>) -> Vector3<f64> {
    v.as_ref().map_or_else(Vector3::zeros, vector)
}

/// An orientation with the logged bits: normalizing again would change the last ones.
pub(super) fn quaternion(q: Option<messages::Quaternion>) -> UnitQuaternion<f64> {
    let q = q.unwrap_or(messages::Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 });
    UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z))
}

/// The pose with the logged bits: normalizing the quaternion again would change the last ones.
pub(super) fn pose(t: &FrameTransform) -> Isometry3<f64> {
    let translation = t.translation.as_ref().map_or_else(Translation3::identity, |v| Translation3::new(v.x, v.y, v.z));
    let rotation = t.rotation.as_ref().map_or_else(Quaternion::identity, |q| Quaternion::new(q.w, q.x, q.y, q.z));
    Isometry3::from_parts(translation, UnitQuaternion::new_unchecked(rotation))
}
