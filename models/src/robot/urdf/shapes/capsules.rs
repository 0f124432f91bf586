//! Capsules from their parts: a cylinder and two balls of its radius at its ends, one after the
//! other in the file. A URDF that other programs read has capsules in this form; as one shape they
//! have exact contact.

use nalgebra::{Isometry3, Point3};

use crate::robot::model::{Geometry, Shape};

/// Deviation of the balls' centres that is rounding, relative to radius and length.
const ROUNDING: f64 = 1e-9;

/// The shapes, with each capsule as one.
pub(super) fn joined(shapes: Vec<Shape>) -> Vec<Shape> {
    let mut all: Vec<Shape> = Vec::with_capacity(shapes.len());
    for shape in shapes {
        all.push(shape);
        if let [.., cylinder, one, other] = &all[..]
            && let Some(capsule) = capsule(cylinder, [one, other])
        {
            all.truncate(all.len() - 3);
            all.push(capsule);
        }
    }
    all
}

fn capsule(cylinder: &Shape, balls: [&Shape; 2]) -> Option<Shape> {
    let Geometry::Cylinder(radius, length) = cylinder.geometry else { return None };
    let is_same = |ball: &Shape| ball.geometry == Geometry::Sphere(radius) && ball.rgba == cylinder.rgba;
    let centre = |ball: &Shape| cylinder.pose.inverse() * Point3::from(ball.pose.translation.vector);
    let [one, other] = balls.map(centre);
    let end = |z: f64| Isometry3::translation(0.0, 0.0, z) * Point3::origin();
    let is_at = |point: &Point3<f64>, z: f64| (point - end(z)).norm() <= ROUNDING * (radius + length);
    let half = 0.5 * length;
    let is_capsule = balls.iter().all(|ball| is_same(ball))
        && (is_at(&one, -half) && is_at(&other, half) || is_at(&one, half) && is_at(&other, -half));
    is_capsule.then(|| Shape { geometry: Geometry::Capsule(radius, length), ..cylinder.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(geometry: Geometry, z: f64) -> Shape {
        let pose = Isometry3::rotation(nalgebra::Vector3::new(0.3, 0.1, -0.2)) * Isometry3::translation(0.1, 0.2, z);
        Shape { pose, geometry, rgba: [1.0; 4] }
    }

    #[test]
    fn a_cylinder_with_balls_at_its_ends_is_a_capsule() {
        let parts = |radius: f64, z: f64| {
            let (ball, cylinder) = (Geometry::Sphere(radius), Geometry::Cylinder(0.1, 0.4));
            vec![shape(ball.clone(), 0.0), shape(cylinder, 0.3), shape(ball.clone(), 0.5), shape(ball, z)]
        };
        let all = joined(parts(0.1, 0.1));
        let geometries: Vec<&Geometry> = all.iter().map(|shape| &shape.geometry).collect();
        assert_eq!(geometries, [&Geometry::Sphere(0.1), &Geometry::Capsule(0.1, 0.4)]);
        assert_eq!(all[1].pose, shape(Geometry::Sphere(0.1), 0.3).pose);
        for other in [parts(0.11, 0.1), parts(0.1, 0.5), parts(0.1, 0.11)] {
            assert_eq!(joined(other.clone()), other);
        }
    }
}
