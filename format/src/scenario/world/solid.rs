//! Models that are one homogeneous primitive: objects of the scenario's own types.

use nalgebra::{Matrix3, Vector3};

use crate::sdf::{Geometry, Pose, Resolved, Shape};
use std::f64::consts::PI;

/// Deviation of a centre of mass (m, relative to the size) and of a tensor (relative to its
/// greatest entry) up to which a body is homogeneous: rounding of printed digits.
const ROUNDING: f64 = 1e-9;

/// A homogeneous primitive.
pub(super) struct Primitive<'a> {
    pub shape: &'a Shape,
    /// Pose of its centre in the model.
    pub pose: Pose,
    pub mass: f64,
}

/// The primitive that a model is; `None` if its shape, mass or inertia is another.
pub(super) fn primitive<'a>(model: &Resolved<'a>) -> Option<Primitive<'a>> {
    let [link] = &model.links[..] else { return None };
    let ([(in_link, shape)], (at, inertial), true) =
        (&link.collisions[..], link.inertial?, model.joints.is_empty() && link.sensors.is_empty())
    else {
        return None;
    };
    let (moments, size) = moments(&shape.geometry)?;
    let offset = in_link.isometry.translation.vector - at.isometry.translation.vector;
    let turn = (in_link.isometry.rotation.inverse() * at.isometry.rotation).to_rotation_matrix();
    let given = turn.matrix() * inertial.tensor * turn.matrix().transpose();
    let expected = Matrix3::from_diagonal(&(moments * inertial.mass));
    let is_homogeneous = inertial.mass > 0.0
        && offset.norm() <= ROUNDING * size
        && (given - expected).amax() <= ROUNDING * expected.amax();
    is_homogeneous.then(|| Primitive { shape, pose: link.pose.then(in_link), mass: inertial.mass })
}

/// Principal moments per mass, m^2, as `assemble/objects.rs` computes them, and the size, m.
fn moments(geometry: &Geometry) -> Option<(Vector3<f64>, f64)> {
    Some(match geometry {
        Geometry::Box(size) => {
            let s = size.component_mul(size);
            (Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 12.0, size.amax())
        }
        Geometry::Sphere(r) => (Vector3::repeat(0.4 * r * r), *r),
        Geometry::Cylinder(r, l) => {
            let across = r * r / 4.0 + l * l / 12.0;
            (Vector3::new(across, across, r * r / 2.0), r.max(*l))
        }
        Geometry::Capsule(r, l) => {
            let (c, e) = (PI * r * r * l, 4.0 / 3.0 * PI * r * r * r);
            let along = (c * r * r / 2.0 + e * 0.4 * r * r) / (c + e);
            let ends = 0.4 * r * r + l * l / 4.0 + 3.0 * r * l / 8.0;
            let across = (c * (r * r / 4.0 + l * l / 12.0) + e * ends) / (c + e);
            (Vector3::new(across, across, along), r.max(*l))
        }
        _ => return None,
    })
}
