//! Time integration: a small [`System`] trait, explicit Runge-Kutta methods with dense output, step size control and event
//! location. Nothing here knows of robots or contact.

pub mod bs23;
pub mod control;
pub mod dopri5;
pub mod event;
pub mod rk4;
pub mod runge_kutta;

pub use bs23::BS23;
pub use control::StepControl;
pub use dopri5::DOPRI5;
pub use rk4::RK4;
pub use runge_kutta::{RungeKutta, Tableau};

/// A system of ordinary differential equations dy/dt = f(t, y).
pub trait System {
    /// Writes f(t, y) into `dy`, which has the length of `y`.
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]);
}
