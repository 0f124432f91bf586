//! Time integration: a small [`System`] trait, the Dormand-Prince pair with dense output, step size control and event
//! location. Nothing here knows of robots or contact.

pub mod control;
pub mod dopri5;
pub mod event;

pub use control::StepControl;
pub use dopri5::Dopri5;

/// A system of ordinary differential equations dy/dt = f(t, y).
pub trait System {
    /// Writes f(t, y) into `dy`, which has the length of `y`.
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]);
}
