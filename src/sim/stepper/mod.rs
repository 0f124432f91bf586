//! Time stepping: explicit Runge-Kutta with event location, and semi-implicit Euler at the velocity level.
//!
//! Imports plant, contact_states, measure and integrate. Called by [`Simulation::step`](super::Simulation::step).

pub mod explicit;
pub mod semi_implicit;
pub mod step_size;

pub use explicit::ExplicitStepper;
pub use semi_implicit::SemiImplicitStepper;

/// What may have jumped at the start of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Discontinuity {
    /// Nothing.
    None,
    /// Commands, or a prescribed acceleration.
    Tick,
    /// A force, or the set of imposed states.
    Corner,
}

/// The stepper of a run.
pub enum Stepper {
    /// Integrates accelerations.
    Explicit(Box<ExplicitStepper>),
    /// Steps velocities by impulses.
    SemiImplicit(Box<SemiImplicitStepper>),
}
