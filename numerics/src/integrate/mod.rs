//! Time integration of `dy/dt = f(t, y)`.
//!
//! A small [`System`] trait, explicit Runge-Kutta methods with dense output ([`RungeKutta`]; one
//! [`Tableau`] per method: `dopri5`, `bs23`, `rk4`), a Rosenbrock method and backward
//! differentiation formulas for a stiff part of low rank ([`Rosenbrock`], [`Bdf`]), step-size
//! control ([`StepControl`], `error_norm`) and event location on dense output ([`event_location`]). A
//! new explicit method is one file with a tableau.
//!
//! `sim` steps with it, `assemble` chooses the tableau.
//!
//! Imports: `math`. Used by: `sim`, `assemble`.

pub mod bdf;
pub mod bs23;
pub mod dopri5;
pub mod error_norm;
pub mod event_location;
pub mod rk4;
pub mod rosenbrock;
pub mod runge_kutta;
pub mod step_control;
pub mod stiff_part;
pub mod stiff_solver;
#[cfg(test)]
mod test_systems;

pub use bdf::Bdf;
pub use bs23::BS23;
pub use dopri5::DOPRI5;
pub use error_norm::error_norm;
pub use rk4::RK4;
pub use rosenbrock::Rosenbrock;
pub use runge_kutta::{RungeKutta, Tableau};
pub use step_control::StepControl;
pub use stiff_part::StiffPart;
pub use stiff_solver::StiffSolver;

/// A system of ordinary differential equations dy/dt = f(t, y).
pub trait System {
    /// Writes f(t, y) into `dy`, which has the length of `y`.
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]);
}
