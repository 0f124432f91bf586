//! Saved states of simulations.

use std::sync::Mutex;

use pyo3::prelude::*;
use stiction::sim::{Outcome, SimEvent};

use crate::stepped::Commanded;

/// A state of a run, to which it can return.
#[pyclass(frozen, module = "stiction._native")]
pub struct Checkpoint {
    pub key: String,
    /// Simulated time, s.
    #[pyo3(get)]
    pub time: f64,
    /// None before the first step.
    pub kept: Option<Mutex<stiction::sim::Checkpoint>>,
    pub commanded: Commanded,
    pub end: Option<(Outcome, String)>,
    /// Events so far.
    pub events: Vec<SimEvent>,
    /// The Python functions of the simulation.
    pub functions: Vec<usize>,
}

#[pymethods]
impl Checkpoint {
    fn __repr__(&self) -> String {
        format!("<Checkpoint of {} at {} s>", self.key, self.time)
    }
}
