//! Interactive session: simulates a scenario step by step and edits it at control ticks.
//!
//! Each command that changes the motion adds an entry to the scenario, such as an event, a task or
//! a force, at the present control tick. The edited document is read and built like any scenario,
//! and the simulation continues with it. So a session is a scenario at any time, and a saved
//! session replays to the same bits.
//!
//! Imports: `geometry`, `text`, `robot`, `dynamics`, `task`, `sim`, `scenario`, `files`, `script`,
//! `log`, `assemble`, `batch`, `export`. Used by: `cli`.

mod arguments;
mod commands;
mod console_error;
mod cursor;
mod displayed_log;
mod player;
mod recording;
mod run_goal;
mod scenario_document;
mod session;
mod session_observer;

pub use commands::{COMMANDS, Command, Names, complete, reference};
pub use console_error::ConsoleError;
pub use session::Session;
