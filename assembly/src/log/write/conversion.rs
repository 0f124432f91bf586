//! Converts simulation types to message types.

use crate::log::messages;
use foxglove::messages::{Color, Point3, Pose, Quaternion, Timestamp, Vector3};
use nalgebra as na;

/// Simulated seconds as nanoseconds from the start of the run; negative times and NaN become 0.
pub fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

pub(super) fn timestamp(ns: u64) -> Timestamp {
    let seconds = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, (ns % 1_000_000_000) as u32)
}

pub(super) fn vector(v: &na::Vector3<f64>) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

pub(super) fn point(v: &na::Vector3<f64>) -> Point3 {
    Point3 { x: v.x, y: v.y, z: v.z }
}

pub(super) fn quaternion(q: &na::UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: q.i, y: q.j, z: q.k, w: q.w }
}

pub(super) fn pose(p: &na::Isometry3<f64>) -> Pose {
    Pose { position: Some(vector(&p.translation.vector)), orientation: Some(quaternion(&p.rotation)) }
}

pub(super) fn colour(rgba: [f32; 4]) -> Color {
    let [r, g, b, a] = rgba.map(f64::from);
    Color { r, g, b, a }
}

/// A vector in a message of [`messages`].
pub(super) fn to_message(v: &na::Vector3<f64>) -> messages::Vector3 {
    messages::Vector3 { x: v.x, y: v.y, z: v.z }
}
