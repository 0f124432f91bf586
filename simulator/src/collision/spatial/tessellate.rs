//! Tessellates shapes to points whose convex hull contains the shape.
//!
//! A circle of radius r becomes a regular polygon of n corners around it, at r / cos(pi / n), so
//! that it contains the shape. A sphere becomes n meridians and 2 ceil(n / 4) bands of equal
//! latitude, moved outward until every face clears it. The excess of the polyhedron is at most,
//! relative to the radius:
//!
//! ```text
//! cylinder: 1 / cos(pi / n) - 1;    sphere: about 1 / cos^2(pi / n) - 1       (n = 16: 2 and 4 %)
//! ```

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use crate::math;
use crate::robot::{Geometry, Shape};

/// Points of a shape in the frame of its pose, m; `n` corners to a circle, at least 3.
pub fn points(shape: &Shape, n: usize) -> Vec<Vector3<f64>> {
    let own: Vec<Vector3<f64>> = match &shape.geometry {
        Geometry::Box(size) => (0..8).map(|k| corner(&(size / 2.0), k)).collect(),
        Geometry::Cylinder(radius, length) => {
            [-1.0, 1.0].iter().flat_map(|end| ring(radius / math::cos(PI / n as f64), end * length / 2.0, n)).collect()
        }
        Geometry::Sphere(radius) => ball(*radius, 0.0, n),
        Geometry::Capsule(radius, length) => ball(*radius, *length, n),
        Geometry::Mesh(vertices, _) => vertices.iter().map(|p| p.coords).collect(),
    };
    own.into_iter().map(|p| (shape.pose * Point3::from(p)).coords).collect()
}

fn corner(half: &Vector3<f64>, k: usize) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] })
}

fn ring(radius: f64, z: f64, n: usize) -> impl Iterator<Item = Vector3<f64>> {
    (0..n).map(move |k| {
        let (s, c) = math::sin_cos(2.0 * PI * k as f64 / n as f64);
        Vector3::new(radius * c, radius * s, z)
    })
}

/// Two hemispheres, `length` apart along z.
fn ball(radius: f64, length: f64, n: usize) -> Vec<Vector3<f64>> {
    let bands = n.div_ceil(4);
    let latitude = |k: usize| PI / 2.0 * k as f64 / bands as f64;
    // Middle of a side of ring k of a unit ball, across the axis and along it; the sides between
    // two rings lie in one plane, so its distance from the centre is that of the line through the
    // two middles.
    let side = |k: usize| {
        let (s, c) = math::sin_cos(latitude(k));
        (c * math::cos(PI / n as f64), s)
    };
    let clearance = |k: usize| {
        let ((x0, z0), (x1, z1)) = (side(k), side(k + 1));
        (x0 * z1 - x1 * z0).abs() / math::hypot(x1 - x0, z1 - z0)
    };
    let least = (0..bands).map(clearance).fold(f64::INFINITY, f64::min);
    // A prism connects the two equators when they are apart.
    let least = least.min(math::cos(PI / n as f64));
    let outer = radius / least;
    let half = length / 2.0;
    let rings = (0..bands).flat_map(|k| {
        let (s, c) = math::sin_cos(latitude(k));
        let both: &[f64] = if k == 0 && length == 0.0 { &[1.0] } else { &[1.0, -1.0] };
        both.iter().flat_map(move |sign| ring(outer * c, sign * (outer * s + half), n)).collect::<Vec<_>>()
    });
    rings.chain([1.0, -1.0].map(|sign| Vector3::new(0.0, 0.0, sign * (outer + half)))).collect()
}
