//! Link poses for given joint positions, without the velocities and inertias that collision tests
//! do not need.
//!
//! ```text
//! R_i = R_p(i) R_i0 Rz(q_i),   p_i = p_p(i) + R_p(i) d_i          (revolute; prismatic adds z_i q_i to p_i)
//! ```

use nalgebra::{Matrix3, Vector3};

use crate::math;
use crate::robot::{JointKind, Model};

/// Pose of a link.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LinkPose {
    /// Orientation of the link's internal frame.
    pub rotation: Matrix3<f64>,
    /// Origin of that frame, m.
    pub origin: Vector3<f64>,
}

impl LinkPose {
    /// The identity.
    pub const IDENTITY: Self = LinkPose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        origin: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Transforms a point of the link's internal frame.
    #[inline]
    pub fn point(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * p + self.origin
    }
}

/// Poses of all links' internal frames relative to the root's, for the joint positions `q`, rad or
/// m.
///
/// # Panics
/// When `q` or `poses` is shorter than the model's joints or links.
pub fn link_poses(model: &Model, q: &[f64], poses: &mut [LinkPose]) {
    poses[0] = LinkPose::IDENTITY;
    for (i, &q) in q[..model.nj()].iter().enumerate() {
        link_pose(model, i + 1, q, poses);
    }
}

/// The pose of one link, whose joint is at `q`, from its parent's.
#[inline]
pub(crate) fn link_pose(model: &Model, i: usize, q: f64, poses: &mut [LinkPose]) {
    let link = &model.links[i];
    let up = &poses[link.parent.map_or(0, |p| p.0)];
    let turned = up.rotation * link.rotation;
    let origin = up.point(&link.offset);
    poses[i] = match model.joints[i - 1].kind {
        JointKind::Revolute | JointKind::Continuous => {
            let (s, c) = math::sin_cos(q);
            let (x, y, z) = (turned.column(0), turned.column(1), turned.column(2));
            LinkPose { rotation: Matrix3::from_columns(&[x * c + y * s, y * c - x * s, z.into()]), origin }
        }
        JointKind::Prismatic => LinkPose { rotation: turned, origin: origin + turned.column(2) * q },
    };
}
