//! Poses of the links in a posture, relative to the root's URDF frame.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::model::{JointKind, Model};

/// Poses of the links' **internal** frames; `q` has one number per joint, rad or m.
pub fn link_poses(model: &Model, q: &[f64]) -> Vec<Isometry3<f64>> {
    let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(model.links.len());
    for (i, link) in model.links.iter().enumerate() {
        let Some(parent) = link.parent else {
            poses.push(link.urdf_frame.inverse());
            continue;
        };
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(link.rotation));
        let at_zero = Isometry3::from_parts(Translation3::from(link.offset), rotation);
        let motion = match model.joints[i - 1].kind {
            JointKind::Prismatic => Isometry3::translation(0.0, 0.0, q[i - 1]),
            _ => Isometry3::rotation(Vector3::z() * q[i - 1]),
        };
        poses.push(poses[parent.0] * at_zero * motion);
    }
    poses
}

/// Centre of mass of all moving links, in the root's URDF frame, m.
pub(super) fn centre_of_mass(model: &Model, poses: &[Isometry3<f64>]) -> Vector3<f64> {
    let first = usize::from(model.base == super::model::Base::Fixed);
    let weighted: Vector3<f64> = model
        .links
        .iter()
        .zip(poses)
        .skip(first)
        .map(|(link, pose)| (pose * nalgebra::Point3::from(link.com)).coords * link.mass)
        .sum();
    if model.mass() > 0.0 { weighted / model.mass() } else { weighted }
}
