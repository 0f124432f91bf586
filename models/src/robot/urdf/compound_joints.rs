//! Joints with more than one motion, as chains of simple joints with massless links between them.

use nalgebra::Vector3;
use urdf_rs::JointType;

use crate::robot::model::JointKind;

/// One motion of a joint.
pub(super) struct Part {
    /// Suffix of the joint's name; empty for the only motion of a simple joint.
    pub suffix: &'static str,
    pub kind: JointKind,
    /// Unit axis in the joint's frame.
    pub axis: Vector3<f64>,
}

/// The motions of a planar or floating joint, from the parent's side; `None` for a simple joint.
/// `axis` is the normal of a planar joint.
pub(super) fn parts(kind: &JointType, axis: &Vector3<f64>) -> Option<Vec<Part>> {
    let slide = |suffix, axis| Part { suffix, kind: JointKind::Prismatic, axis };
    let turn = |suffix, axis| Part { suffix, kind: JointKind::Continuous, axis };
    match kind {
        JointType::Planar => {
            let helper = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
            let across = (helper - axis * axis.dot(&helper)).normalize();
            let along = axis.cross(&across);
            Some(vec![slide("x", across), slide("y", along), turn("turn", *axis)])
        }
        JointType::Floating => Some(vec![
            slide("x", Vector3::x()),
            slide("y", Vector3::y()),
            slide("z", Vector3::z()),
            turn("yaw", Vector3::z()),
            turn("pitch", Vector3::y()),
            turn("roll", Vector3::x()),
        ]),
        _ => None,
    }
}
