//! One run: state, coupling of the physics rooms, outcome.

pub mod actuator;
pub mod build;
mod comply;
mod decide;
mod drive;
pub mod error;
mod explicit;
mod fixed;
mod freeze;
mod guide;
mod imposed;
mod jam;
mod lag;
pub mod layout;
mod ledger;
mod marks;
mod measure;
pub mod observe;
mod pairing;
pub mod patch;
pub mod plant;
mod prescribe;
mod project;
pub mod report;
mod sample;
mod sense;
pub mod setup;
pub mod simulation;
mod speed;
mod watch;
mod zones;

pub use error::Stop;
pub use ledger::Balance;
pub use report::*;
pub use setup::Setup;
pub use simulation::Simulation;
