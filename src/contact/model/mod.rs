//! The contact problem and what its solutions must satisfy: states, the reduced problem, friction limits, residuals.

pub mod capacity;
pub mod frozen;
pub mod group;
pub mod pressure;
pub mod problem;
pub mod residual;
pub mod state;
