//! A run apart from its stepper: control ticks, scenario events, carried objects, self-collision.
//!
//! [`RunState`] holds plant, tasks, sensors and measurements; the other files act on it between steps.
//!
//! Imports every room of sim but `contact_states` and `stepper`, which work on [`RunState`]. Called by
//! [`Simulation`](super::Simulation).

mod carried_objects;
mod control_tick;
mod scenario_events;
mod self_collision;
mod state;

pub use state::RunState;
