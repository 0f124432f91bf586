//! One run: integrates the robot on its floor, calls tasks and sensors, and measures.
//!
//! [`Setup`] describes a run, [`Simulation`] executes it, an [`Observer`] receives snapshots,
//! events and samples.
//!
//! | module | content |
//! |---|---|
//! | `plant` | equations of motion with the contact states held fixed |
//! | `actuation` | drives, joint friction and stops, lag, speed limits, paths of kinematic joints |
//! | `floor` | the plane and its friction regions |
//! | `bodies` | bodies that touch each other, and the patches of touching pairs |
//! | `sensing` | sensors with errors, IMU, base estimators |
//! | `run` | state of a run without its stepper: control ticks, scenario events, carried objects |
//! | `contact_states` | choice of contact states at an instant |
//! | `stepper` | time stepping: explicit, with implicit forces, and semi-implicit at the velocity level |
//! | `measure` | residuals, energy balance, milestones, samples, snapshots |
//!
//! `assemble` builds a [`Setup`] from a scenario; library users fill one. Does not access files or
//! logs.
//!
//! Imports: `math`, `geometry`, `integrate`, `random`, `text`, `metrics`, `robot`, `terrain`,
//! `dynamics`, `patches`, `contact`, `task`, `force`, `collision`. Used by: `log`, `assemble`,
//! `results`, `remote`, `batch`, `merge`, `compare`, `report`, `replay`, `api`, `cli`, `console`,
//! `fit`.

pub mod actuation;
pub mod bodies;
pub mod carried_object;
mod checkpoint;
pub mod command_source;
mod contact_states;
mod continuation;
pub mod event_kind;
pub mod floor;
pub mod measure;
pub mod plant;
pub mod remote_run;
pub mod report;
mod run;
pub mod run_error;
pub mod saved_state;
pub mod scenario_event;
pub mod self_collision;
pub mod sensing;
pub mod setup;
pub mod simulation;
mod stepper;
mod stepping;
mod termination;

pub use carried_object::CarriedObject;
pub use checkpoint::Checkpoint;
pub use command_source::CommandSource;
pub use event_kind::EventKind;
pub use floor::Floor;
pub use measure::energy_balance::EnergyBalance;
pub use remote_run::{RemoteRobot, RemoteRun};
pub use report::*;
pub use run_error::RunError;
pub use scenario_event::ScenarioEvent;
pub use setup::Setup;
pub use simulation::Simulation;
