//! Poses of elements: position and one of five kinds of orientation.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};

use super::compiler::Compiler;
use super::view::View;
use crate::robot::robot_error::RobotError;

const KINDS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// The pose in the parent's frame: identity by default.
pub(super) fn pose(view: &View, compiler: &Compiler) -> Result<Isometry3<f64>, RobotError> {
    let position = Vector3::from(view.array::<3>("pos")?.unwrap_or_default());
    Ok(Isometry3::from_parts(position.into(), orientation(view, compiler)?))
}

/// The orientation by the kind that the element has, else by that of its nearest class.
pub(super) fn orientation(view: &View, compiler: &Compiler) -> Result<UnitQuaternion<f64>, RobotError> {
    let document = view.document;
    let given = |&&id: &&usize| KINDS.iter().any(|kind| document.attribute(id, kind).is_some());
    let Some(&level) = view.levels.iter().find(given) else { return Ok(UnitQuaternion::identity()) };
    let mut kinds = KINDS.iter().filter(|kind| document.attribute(level, kind).is_some());
    let kind = *kinds.next().unwrap_or(&KINDS[0]);
    if let Some(second) = kinds.next() {
        let message = format!("{} has two orientations, `{kind}` and `{second}`", document.describe(level));
        return Err(document.attribute_fault(level, second, message).expected("one of them").invalid());
    }
    let level = View::bare(document, level);
    let short = || level.fault(kind, "a direction of length above 0").invalid();
    let unit = |v: Vector3<f64>| Unit::try_new(v, 1e-10).ok_or_else(short);
    match kind {
        "quat" => {
            let [w, x, y, z] = level.array("quat")?.unwrap_or([1.0, 0.0, 0.0, 0.0]);
            UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-10).ok_or_else(short)
        }
        "axisangle" => {
            let [x, y, z, angle] = level.array("axisangle")?.unwrap_or_default();
            Ok(UnitQuaternion::from_axis_angle(&unit(Vector3::new(x, y, z))?, angle * compiler.angle))
        }
        "euler" => Ok(euler(level.array("euler")?.unwrap_or_default(), compiler)),
        "xyaxes" => {
            let [a, b, c, d, e, f] = level.array("xyaxes")?.unwrap_or_default();
            let x = unit(Vector3::new(a, b, c))?;
            let y = Vector3::new(d, e, f);
            let y = unit(y - *x * x.dot(&y))?;
            let axes = Matrix3::from_columns(&[*x, *y, x.cross(&y)]);
            Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)))
        }
        _ => Ok(from_z(&unit(Vector3::from(level.array::<3>("zaxis")?.unwrap_or_default()))?)),
    }
}

/// Rotations about the axes of `eulerseq`, one after the other.
pub(super) fn euler(angles: [f64; 3], compiler: &Compiler) -> UnitQuaternion<f64> {
    let mut rotation = UnitQuaternion::identity();
    for (letter, angle) in compiler.eulerseq.iter().zip(angles) {
        let axis = match letter.to_ascii_lowercase() {
            'x' => Vector3::x_axis(),
            'y' => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        };
        let turn = UnitQuaternion::from_axis_angle(&axis, angle * compiler.angle);
        rotation = if letter.is_lowercase() { rotation * turn } else { turn * rotation };
    }
    rotation
}

/// The shortest rotation from z to a direction; half a turn about x to -z.
pub(super) fn from_z(axis: &Unit<Vector3<f64>>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}
