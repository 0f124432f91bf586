//! Goal of the planned robot: soles, centre of mass and root.

use crate::dynamics::Motion;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Targets in world axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// For each sole the centroid of its vertices (m) and the orientation of its link.
    pub soles: Vec<Isometry3<f64>>,
    /// Centre of mass, m.
    pub com: Vector3<f64>,
    /// Orientation of the root link.
    pub root: UnitQuaternion<f64>,
}

/// Velocities of the targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// For each sole the velocity of its centroid (m/s) and its angular velocity (rad/s), world
    /// axes.
    pub soles: Vec<Motion>,
    /// Velocity of the centre of mass, m/s.
    pub com: Vector3<f64>,
    /// Angular velocity of the root link, rad/s.
    pub root: Vector3<f64>,
}

impl Rates {
    /// At rest.
    pub fn zero(soles: usize) -> Self {
        Rates { soles: vec![Motion::ZERO; soles], com: Vector3::zeros(), root: Vector3::zeros() }
    }
}
