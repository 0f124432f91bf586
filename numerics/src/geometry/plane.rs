//! A plane with its own axes.

use nalgebra::{Matrix3, Vector2, Vector3};

/// A plane through a point; the third axis is its upward normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Axes in the world, as columns.
    pub rotation: Matrix3<f64>,
    /// A point of the plane, world, m.
    pub point: Vector3<f64>,
}

impl Plane {
    /// The world's x-y plane.
    pub const LEVEL: Plane = Plane {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        point: Vector3::new(0.0, 0.0, 0.0),
    };

    /// A world vector in the plane's axes.
    pub fn to_plane(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(v)
    }

    /// Coordinates along the plane's first two axes of a world point, m.
    pub fn flat(&self, p: &Vector3<f64>) -> Vector2<f64> {
        self.to_plane(&(p - self.point)).xy()
    }

    /// The world point of the plane with these coordinates.
    pub fn world(&self, p: &Vector2<f64>) -> Vector3<f64> {
        self.point + self.rotation.column(0) * p.x + self.rotation.column(1) * p.y
    }

    /// The point of the plane below (or above) a world point, along the normal.
    pub fn project(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.world(&self.flat(p))
    }

    /// Height of a world point above the plane, m.
    pub fn height(&self, p: &Vector3<f64>) -> f64 {
        self.rotation.column(2).dot(&(p - self.point))
    }
}
