//! Events of the scenario: parameters that change while running, tasks that end, states saved and
//! restored.
//!
//! An event happens at its instant, between two steps; contact states are then selected again. The
//! energy that a new payload, another gravity or a restored state adds counts as work of external
//! forces.

use super::floor::Floor;
use crate::force::Force;
use crate::robot::Model;
use nalgebra::Vector3;
use std::sync::Arc;

/// An event and its changes.
#[derive(Default)]
pub struct ScenarioEvent {
    /// Time, s.
    pub at: f64,
    /// Message for the log.
    pub message: String,
    /// Numbers of the tasks that end.
    pub end_tasks: Vec<usize>,
    /// Number of the saved state to overwrite.
    pub save: Option<usize>,
    /// Number of the saved state to restore.
    pub restore: Option<usize>,
    /// New robot, of the same structure.
    pub model: Option<Arc<Model>>,
    /// New gains: joint, kp, kd.
    pub gains: Vec<(usize, f64, f64)>,
    /// New gravity, m/s^2.
    pub gravity: Option<Vector3<f64>>,
    /// New floor, with the same plane.
    pub floor: Option<Floor>,
    /// New coefficient of restitution.
    pub restitution: Option<f64>,
    /// New force models, each with the number of the model that it replaces.
    pub forces: Vec<(usize, Box<dyn Force>)>,
}
