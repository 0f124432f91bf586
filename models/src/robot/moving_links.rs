//! Links and joints before their values are set, as all readers of robots build them.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::friction::{SLIP_SPEED, STRIBECK_SPEED};
use super::model::{Drive, Joint, JointKind, Link, LinkId};

/// Greatest number of moving joints. The time of a step grows with the third power of the length of
/// a chain: 0.3 s for one of 1024 joints, which is also how late a run is cancelled.
pub(super) const MAX_JOINTS: usize = 1024;

/// Limits from this size on are none: what formats write that have no other word for it.
pub const NO_LIMIT: f64 = 1e16;

/// A joint without limits, friction or actuator.
pub(super) fn free_joint(name: String, kind: JointKind) -> Joint {
    Joint {
        name,
        kind,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity_limit: f64::INFINITY,
        effort_limit: f64::INFINITY,
        damping: 0.0,
        friction: 0.0,
        static_friction: 0.0,
        stribeck_velocity: STRIBECK_SPEED,
        slip_velocity: SLIP_SPEED,
        stop: None,
        armature: 0.0,
        lag: 0.0,
        drive: Drive::default(),
        // Counts as configured, so that a scenario's default drive does not apply.
        drive_configured: true,
    }
}

/// The rotation that takes z to a unit axis. Axes along x, y or z get exact quaternions, so that a
/// robot drawn with them has rotation matrices of zeros and ones.
pub(super) fn z_to(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let exact = |w: f64, x: f64, y: f64, z: f64| UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
    match (axis.x, axis.y, axis.z) {
        (0.0, 0.0, z) if z > 0.0 => UnitQuaternion::identity(),
        (0.0, 0.0, _) => exact(0.0, 1.0, 0.0, 0.0),
        (x, 0.0, 0.0) if x > 0.0 => exact(0.5, 0.5, 0.5, 0.5),
        (_, 0.0, 0.0) => exact(0.5, 0.5, -0.5, -0.5),
        (0.0, y, 0.0) if y > 0.0 => exact(0.5, -0.5, -0.5, -0.5),
        (0.0, _, 0.0) => exact(0.5, 0.5, 0.5, -0.5),
        // The half-way quaternion (1 + z . a, z x a) is ill-conditioned near -z: start from there
        // by a half turn about x.
        (x, y, z) if z < 0.0 => shortest(-y, x, z) * exact(0.0, 1.0, 0.0, 0.0),
        (x, y, z) => shortest(-y, x, z),
    }
}

/// The shortest rotation to (.., .., z) from z (or from -z when `z` is negative); `cx`, `cy` are
/// those of z x axis.
fn shortest(cx: f64, cy: f64, z: f64) -> UnitQuaternion<f64> {
    let sign = z.signum();
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(1.0 + z.abs(), sign * cx, sign * cy, 0.0))
}

/// A link without mass, shapes or welded links.
pub(super) fn bare_link(name: &str, parent: Option<LinkId>) -> Link {
    Link {
        name: name.to_owned(),
        parent,
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass: 0.0,
        com: Vector3::zeros(),
        inertia: Matrix3::zeros(),
        urdf_frame: Isometry3::identity(),
        merged: Vec::new(),
        visuals: Vec::new(),
        collisions: Vec::new(),
    }
}
