//! Points of interest: positions that tasks show in logs and viewers.

use nalgebra::Vector3;

/// A point that a task shows, such as its target or its planned zero-moment point. It has no effect
/// on the simulation.
#[derive(Clone, PartialEq, Debug)]
pub struct PointOfInterest {
    /// Its name.
    pub name: String,
    /// World, m; none while it is not shown.
    pub position: Option<Vector3<f64>>,
}

impl PointOfInterest {
    /// A point without position.
    pub fn named(name: impl Into<String>) -> Self {
        PointOfInterest { name: name.into(), position: None }
    }
}
