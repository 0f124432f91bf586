//! Time stepping: methods that integrate accelerations, explicit or with implicit forces ([`step_methods`]), with event
//! location ([`explicit`]), and semi-implicit Euler at the velocity level. Where contact states alternate faster than
//! steps resolve, the first advance by the second.
//!
//! Imports plant, contact_states, measure and integrate. Called by
//! [`Simulation::step`](super::Simulation::step).

pub mod explicit;
pub mod implicit_choice;
pub mod semi_implicit;
pub mod sliding_mode;
pub mod step_methods;
pub mod step_size;

pub use explicit::ExplicitStepper;
pub use semi_implicit::SemiImplicitStepper;

/// Discontinuity at the start of a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Discontinuity {
    /// No discontinuity.
    None,
    /// Of commands or a prescribed acceleration.
    Tick,
    /// Of a force or the set of imposed states.
    Corner,
}

/// The stepper of a run.
#[derive(Clone)]
pub enum Stepper {
    /// Integrates accelerations.
    Explicit(Box<ExplicitStepper>),
    /// Steps velocities by impulses.
    SemiImplicit(Box<SemiImplicitStepper>),
}
