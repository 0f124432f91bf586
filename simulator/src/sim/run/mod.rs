//! A run without its stepper: control ticks, scenario events, carried objects, self-collision.
//!
//! [`RunState`] contains plant, tasks, sensors and measurements; the other files act on it between
//! steps.
//!
//! Imports every module of sim except `contact_states` and `stepper`, which work on [`RunState`].
//! Called by [`Simulation`](super::Simulation).

mod carried_objects;
mod commands_ahead;
mod control_tick;
mod scenario_events;
mod self_collision;
mod state;

pub use commands_ahead::CommandsAhead;
pub(in crate::sim) use control_tick::run_tasks;
pub use state::{Deferral, RunState};
