//! Scenario runner for legged-robot contact: exact Coulomb friction against faster methods, with
//! logs, residuals and verdicts.
//!
//! The program `runner` runs scenario files; this library runs them from Rust. [`Scenario`] loads a
//! file, its [`runs`](Scenario::runs) become [`Simulation`]s, which can be stepped and read at any
//! time, with force models ([`Force`]), tasks ([`Task`]) and contact methods of your own in their
//! [`Setup`]. [`run_batch`] runs files in parallel and writes logs, summary and report.
//!
//! Blocks on two floors, which friction and a force model of this program slow down:
//!
//! ```
//! use stiction::nalgebra::Vector3;
//! use stiction::{AppliedForces, Force, ForceContext, LinkId, Scenario, Simulation};
//!
//! /// A brake at the origin of the root link: `f = -c v`.
//! struct Brake {
//!     c: f64, // N s/m
//! }
//!
//! impl Force for Brake {
//!     fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
//!         let state = context.state;
//!         let force = -self.c * Vector3::from_column_slice(&state.v[..3]);
//!         applied.wrench(context, LinkId(0), &state.position, &force, &Vector3::zeros());
//!     }
//! }
//!
//! # fn main() -> Result<(), stiction::Error> {
//! // A scenario as text; its sweep expands to two runs.
//! let text = r#"
//!     duration = 0.5                                    # s
//!     robot = { model = "robots/block/block.toml", base = { linear_velocity = [1, 0, 0] } }
//!     sweep = { grid = { "floor.friction" = [0.3, 0.6] } }
//! "#;
//! for run in Scenario::parse("brake.toml", text)?.runs()? {
//!     let mut setup = run.setup()?;
//!     setup.forces.push(Box::new(Brake { c: 2.0 }));
//!     let mut simulation = Simulation::new(setup)?;
//!
//!     // Stepping, then contact states and forces of the block's only sole.
//!     simulation.advance_to(0.1, &mut ())?;
//!     assert_eq!(simulation.contact_states().next().unwrap().to_string(), "face-dynamic");
//!     let normal: f64 = simulation.snapshot().soles[0].forces.iter().map(|force| force.z).sum();
//!     assert!((normal - 9.81).abs() < 1e-9); // 1 kg; rounding
//!
//!     // m v' = -mu m g - c v ends after T = m/c ln(1 + c v / (mu m g)), m v / c - mu g (m/c) T away.
//!     simulation.run_to_end(&mut ())?;
//!     let mu_g = 9.81 * run.scenario.floor.friction.static_;
//!     let distance = 0.5 - 0.5 * mu_g * (0.5 * (1.0 + 2.0 / mu_g).ln());
//!     let x = simulation.metrics().final_base_position[0];
//!     assert!((x - distance).abs() < 1e-6); // the integrator's default tolerances
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A task is added by `setup.tasks.add(start, Box::new(task))`; `examples/` has one, and a contact
//! method outside the crate.
//!
//! The other modules of the crate belong to the program and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

// Modules of the program. They are public for `runner`, tests and benches, but are not part of the
// documented library. They are hidden from rustdoc alone, so that the lint above covers them too.
mod api;
#[cfg_attr(doc, doc(hidden))]
pub mod cli;
#[cfg_attr(doc, doc(hidden))]
pub mod compare;
#[cfg_attr(doc, doc(hidden))]
pub mod console;
#[cfg_attr(doc, doc(hidden))]
pub mod export;
#[cfg_attr(doc, doc(hidden))]
pub mod fit;
#[cfg_attr(doc, doc(hidden))]
pub mod history;
#[cfg_attr(doc, doc(hidden))]
pub mod live;
#[cfg_attr(doc, doc(hidden))]
pub mod merge;
#[cfg_attr(doc, doc(hidden))]
pub mod replay;
#[cfg_attr(doc, doc(hidden))]
pub mod report;
#[cfg_attr(doc, doc(hidden))]
pub mod schema_page;
#[cfg_attr(doc, doc(hidden))]
pub mod submit;
#[cfg_attr(doc, doc(hidden))]
pub mod view;
#[cfg_attr(doc, doc(hidden))]
pub mod web;

// Modules of the other crates, under the same paths.
#[cfg_attr(doc, doc(hidden))]
pub use stiction_assembly::{assemble, convert, files, log, policy, script};
#[cfg_attr(doc, doc(hidden))]
pub use stiction_format::{scenario, search, statistics};
#[cfg_attr(doc, doc(hidden))]
pub use stiction_models::{input, mesh, metrics, robot, sdf, text};
#[cfg_attr(doc, doc(hidden))]
pub use stiction_numerics::{geometry, integrate, linalg, math, random};
#[cfg_attr(doc, doc(hidden))]
pub use stiction_runs::{batch, remote, results};
#[doc(inline)]
pub use stiction_simulator::patches;
#[cfg_attr(doc, doc(hidden))]
pub use stiction_simulator::{collision, contact, dynamics, force, motion, sim, task, terrain};

/// Types of the fields of [`Setup`].
pub mod setup {
    pub use crate::collision::avoidance::Settings as AvoidanceSettings;
    pub use crate::integrate::{BS23, DOPRI5, RK4, Tableau};
    pub use crate::sim::actuation::kinematic_paths::Interpolation;
    pub use crate::sim::floor::{Floor, patch::Patch};
    pub use crate::sim::self_collision::SelfCollisionSetup;
    pub use crate::sim::sensing::{channel_error::SensorErrors, estimator::EstimatorSetup, imu::Imu};
    pub use crate::sim::setup::{ContactSetup, Forced, ImplicitSteps, IntegratorSetup, Start};
    pub use crate::sim::{CarriedObject, CommandSource, ScenarioEvent};
    pub use crate::task::TaskServer;
}

/// Traits and data types of contact methods; see [`contact_methods::ContactMethod`].
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

pub use api::{Error, Run, Scenario, run_batch};
pub use batch::{Options, Report};
pub use contact::model::state::SoleState;
pub use dynamics::State;
pub use force::{AppliedForces, Force, ForceContext};
pub use nalgebra;
pub use robot::{JointId, LinkId, Model, Robot, SoleId};
pub use scenario::Run as ScenarioRun;
pub use sim::{Metrics, Observer, Outcome, RunError, Setup, SimEvent, Simulation, Snapshot};
pub use task::{Command, Context, Foresight, Status, Task, TaskMemory, TaskResult};
