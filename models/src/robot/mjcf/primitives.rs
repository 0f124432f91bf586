//! Volume and inertia of primitives of density 1, full or as shells.
//!
//! Full bodies: any mechanics textbook. Shells are sums of disks, tubes, hemispheres and plates of
//! one surface density. Sizes are MuJoCo's: radii and half lengths, m.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::robot::rigid_inertia::RigidInertia;

/// A shape with mass.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Primitive {
    /// Radius.
    Sphere(f64),
    /// Radius, half length of the cylindrical part.
    Capsule(f64, f64),
    /// Half axes.
    Ellipsoid(Vector3<f64>),
    /// Radius, half length.
    Cylinder(f64, f64),
    /// Half edges.
    Box(Vector3<f64>),
}

impl Primitive {
    /// The full body.
    pub fn solid(&self) -> RigidInertia {
        match *self {
            Self::Sphere(r) => round(4.0 / 3.0 * PI * r * r * r, 0.4 * r * r, 0.4 * r * r),
            Self::Ellipsoid(axes) => diagonal(4.0 / 3.0 * PI * axes.product(), |b, c| 0.2 * (b * b + c * c), axes),
            Self::Box(half) => diagonal(8.0 * half.product(), |b, c| (b * b + c * c) / 3.0, half),
            Self::Cylinder(r, h) => round(PI * r * r * 2.0 * h, r * r / 4.0 + h * h / 3.0, r * r / 2.0),
            Self::Capsule(r, h) => {
                let tube = PI * r * r * 2.0 * h;
                let ball = 4.0 / 3.0 * PI * r * r * r;
                let mass = tube + ball;
                // The centre of a hemisphere is 3/8 r above its face, at h.
                let across = tube * (r * r / 4.0 + h * h / 3.0) + ball * (0.4 * r * r + h * h + 0.75 * h * r);
                round(mass, across / mass, (tube * r * r / 2.0 + ball * 0.4 * r * r) / mass)
            }
        }
    }

    /// The surface; `None` for an ellipsoid, which has no closed form.
    pub fn shell(&self) -> Option<RigidInertia> {
        Some(match *self {
            Self::Sphere(r) => round(4.0 * PI * r * r, 2.0 / 3.0 * r * r, 2.0 / 3.0 * r * r),
            Self::Ellipsoid(_) => return None,
            Self::Cylinder(r, h) => {
                let (caps, tube) = (2.0 * PI * r * r, 4.0 * PI * r * h);
                let across = caps * (r * r / 4.0 + h * h) + tube * (r * r / 2.0 + h * h / 3.0);
                let mass = caps + tube;
                round(mass, across / mass, (caps * r * r / 2.0 + tube * r * r) / mass)
            }
            Self::Capsule(r, h) => {
                let (caps, tube) = (4.0 * PI * r * r, 4.0 * PI * r * h);
                // The centre of a hemisphere's surface is r / 2 above its edge, at h.
                let across = caps * (2.0 / 3.0 * r * r + h * h + h * r) + tube * (r * r / 2.0 + h * h / 3.0);
                let mass = caps + tube;
                round(mass, across / mass, (caps * 2.0 / 3.0 * r * r + tube * r * r) / mass)
            }
            Self::Box(half) => {
                let area = Vector3::new(half.y * half.z, half.x * half.z, half.x * half.y) * 8.0;
                let mass = area.sum();
                // Second moment along an axis: its own two plates at the half edge, a third of it on the others.
                let second = Vector3::from_fn(|i, _| (area[i] + (mass - area[i]) / 3.0) * half[i] * half[i]);
                let tensor = Matrix3::from_diagonal(&second.map(|s| second.sum() - s));
                RigidInertia { mass, com: Vector3::zeros(), tensor }
            }
        })
    }
}

/// A body of revolution about z, by its squared radii of gyration.
fn round(mass: f64, across: f64, along: f64) -> RigidInertia {
    let tensor = Matrix3::from_diagonal(&Vector3::new(across, across, along)) * mass;
    RigidInertia { mass, com: Vector3::zeros(), tensor }
}

fn diagonal(mass: f64, moment: impl Fn(f64, f64) -> f64, half: Vector3<f64>) -> RigidInertia {
    let moments = Vector3::new(moment(half.y, half.z), moment(half.x, half.z), moment(half.x, half.y));
    RigidInertia { mass, com: Vector3::zeros(), tensor: Matrix3::from_diagonal(&moments) * mass }
}
