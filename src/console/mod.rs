//! Interactive session: simulates a scenario step by step and edits it at control ticks.
//!
//! Each command that changes the motion adds an entry to the scenario, such as an event, a task or a
//! force, at the present control tick. The edited document is read and built like any scenario, and the
//! simulation continues with it. So a session is a scenario at any time, and a saved session replays to
//! the same bits.
//!
//! Imports `scenario`, `assemble`, `sim`, `log`, `export`, `files`, `batch` (jobs, opening of logs, live
//! clients) and rooms below them. Called by `cli` (`runner console`).

mod arguments;
mod commands;
mod completion;
mod cursor;
mod displayed_log;
mod error;
mod player;
mod query;
mod recording_commands;
mod run_control;
mod scenario_document;
mod scenario_edits;
mod session;
mod session_observer;
mod task_commands;

pub use commands::{COMMANDS, Command, reference};
pub use completion::{Names, complete};
pub use error::ConsoleError;
pub use session::Session;
