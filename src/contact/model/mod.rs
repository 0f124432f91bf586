//! The contact problem and what its solutions must satisfy: states, the reduced problem, friction limits, residuals.

pub mod friction_capacity;
pub mod pressure;
pub mod problem;
pub mod residual;
pub mod sole_group;
pub mod solution;
pub mod state;
