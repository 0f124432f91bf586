//! Motion and contacts of a simulation, as arrays. SI units, world axes.

use pyo3::prelude::*;
use stiction::sim::SoleSnapshot;

use crate::arrays::{array, of_kind, vector, vectors};

/// Motion of the robot at an instant. Each access of an array makes a new one.
#[pyclass(frozen, module = "stiction._native")]
pub struct State {
    state: stiction::State,
    effort: Vec<f64>,
}

impl State {
    /// Copies a state; `effort` are the efforts of the actuators.
    pub fn new(state: &stiction::State, effort: &[f64]) -> Self {
        State { state: state.clone(), effort: effort.to_vec() }
    }
}

#[pymethods]
impl State {
    /// Simulated time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.state.time
    }

    /// Origin of the root link, m, (3,).
    #[getter]
    fn base_position(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        vector(py, &self.state.position)
    }

    /// Orientation of the root link, quaternion x, y, z, w, (4,).
    #[getter]
    fn base_orientation(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, self.state.rotation.coords.as_slice())
    }

    /// Velocity of the root's origin, m/s, (3,); zero for a fixed base.
    #[getter]
    fn base_linear_velocity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, &base_velocity(&self.state)[..3])
    }

    /// Angular velocity of the root, rad/s, (3,); zero for a fixed base.
    #[getter]
    fn base_angular_velocity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, &base_velocity(&self.state)[3..])
    }

    /// Joint positions, rad or m, (n,).
    #[getter]
    fn q(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, &self.state.joints)
    }

    /// Joint velocities, rad/s or m/s, (n,).
    #[getter]
    fn qd(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, self.state.rates())
    }

    /// Efforts of the actuators, N m or N, (n,).
    #[getter]
    fn effort(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        array(py, &self.effort)
    }
}

/// Linear and angular velocity of the root; zero for a fixed base.
pub fn base_velocity(state: &stiction::State) -> [f64; 6] {
    let mut base = [0.0; 6];
    if state.v.len() > state.joints.len() {
        base.copy_from_slice(&state.v[..6]);
    }
    base
}

/// A contact: a sole, another link on the floor, or a pair of bodies, with k points.
#[pyclass(frozen, get_all, module = "stiction._native")]
pub struct Contact {
    /// Name of the sole or link, or names of the bodies.
    name: String,
    /// `free`, or pattern and mode, such as `face-static`.
    state: String,
    /// Whether any point touches.
    is_closed: bool,
    /// Whether each point touches, (k,).
    clamped: Py<PyAny>,
    /// Positions of the points, m, (k, 3).
    points: Py<PyAny>,
    /// Their velocities, m/s, (k, 3).
    velocities: Py<PyAny>,
    /// Forces on them, N, (k, 3); of a pair those on the first body.
    forces: Py<PyAny>,
}

impl Contact {
    /// Copies a contact.
    pub fn new(py: Python<'_>, name: &str, contact: &SoleSnapshot) -> PyResult<Self> {
        Ok(Contact {
            name: name.to_owned(),
            state: contact.state.clone(),
            is_closed: contact.clamped.contains(&true),
            clamped: of_kind(py, contact.clamped.clone(), "bool")?,
            points: vectors(py, &contact.positions)?,
            velocities: vectors(py, &contact.velocities)?,
            forces: vectors(py, &contact.forces)?,
        })
    }
}

#[pymethods]
impl Contact {
    fn __repr__(&self) -> String {
        format!("Contact(name={:?}, state={:?})", self.name, self.state)
    }
}
