//! Points of interest.

use nalgebra::Vector3;

/// A point that a task shows, such as where it aims or what it takes for the zero-moment point: seen in logs and viewers, felt
/// by nothing.
#[derive(Clone, PartialEq, Debug)]
pub struct PointOfInterest {
    /// Its name.
    pub name: String,
    /// World, m; nowhere when not given.
    pub position: Option<Vector3<f64>>,
}

impl PointOfInterest {
    /// A point that is nowhere yet.
    pub fn named(name: impl Into<String>) -> Self {
        PointOfInterest { name: name.into(), position: None }
    }
}
