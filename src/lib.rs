//! Scenario runner for legged-robot contact: exact Coulomb friction against faster methods, with logs, residuals and
//! verdicts.
//!
//! The program `runner` runs scenario files; this library runs them from Rust. [`Scenario`] loads a file, its
//! [`runs`](Scenario::runs) become [`Simulation`]s, which can be stepped and read at any time, with force models
//! ([`Force`]), tasks ([`Task`]) and contact methods of your own in their [`Setup`]. [`run_batch`] runs files in parallel and
//! writes logs, summary and report.
//!
//! ```
//! # fn main() -> Result<(), stiction::Error> {
//! let scenario = stiction::Scenario::load("scenarios/sliding-block.toml")?;
//! let mut simulation = scenario.runs()?[0].simulation()?;
//! simulation.advance_to(0.2, &mut ())?;
//! assert_eq!(simulation.contact_states().next().unwrap().to_string(), "face-dynamic");
//! simulation.run_to_end(&mut ())?;
//! // The block stops after v0^2 / (2 mu g).
//! assert!((simulation.metrics().final_base_position[0] - 4.0 / 9.81).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```
//!
//! The modules below are the program's rooms. They are public for the program and its tests; only what the crate root
//! exports is meant to be stable.

#![warn(missing_docs)]

mod api;
pub mod assemble;
pub mod batch;
pub mod collision;
pub mod console;
pub mod contact;
pub mod dynamics;
pub mod export;
pub mod files;
pub mod force;
pub mod geometry;
pub mod integrate;
pub mod linalg;
#[cfg(feature = "live")]
pub mod live;
pub mod log;
pub mod metrics;
pub mod motion;
pub mod random;
pub mod remote;
pub mod replay;
pub mod report;
pub mod results;
pub mod robot;
pub mod scenario;
pub mod schema_page;
pub mod script;
pub mod sim;
pub mod submit;
pub mod task;
pub mod text;
pub mod view;

/// What a contact method implements and sees, see [`contact_methods::ContactMethod`].
pub mod contact_methods {
    pub use crate::contact::methods::contact_method::{
        ContactMethod, ContactSolver, Scheme, SelectionInput, StoredEnergy,
    };
    pub use crate::contact::methods::registry::{METHODS, MethodDescriptor, MethodParameters};
    pub use crate::contact::model::problem::{Level, Problem, SoleProblem, Tolerances, Vertex};
    pub use crate::contact::model::solution::Solution;
    pub use crate::contact::model::state::{Mode, Pattern, SoleState, States};
    pub use crate::contact::search::select::Selection;
}

pub use api::{Error, Scenario, run_batch};
pub use batch::{Options, Report};
pub use contact::model::state::SoleState;
pub use dynamics::State;
pub use force::{AppliedForces, Force, ForceContext};
pub use nalgebra;
pub use robot::{LinkId, Model, Robot};
pub use scenario::Run;
pub use sim::{Metrics, Observer, Outcome, RunError, Setup, SimEvent, Simulation, Snapshot};
pub use task::{Command, Context, Status, Task, TaskResult};
