//! One run: state, coupling of the physics rooms, outcome.

pub mod actuator;
mod adaptive;
pub mod build;
mod decide;
pub mod error;
mod fixed;
mod imposed;
mod jam;
pub mod layout;
pub mod observe;
pub mod patch;
pub mod plant;
mod project;
pub mod report;
pub mod setup;
pub mod simulation;
mod watch;
mod zones;

pub use error::Stop;
pub use report::*;
pub use setup::Setup;
pub use simulation::Simulation;
