//! Commands of the console: their table, their handlers and the completion of a line. A handler is
//! a method of [`Session`](crate::console::Session).

mod completion;
mod jump;
mod play;
mod queries;
mod recordings;
mod run_control;
mod scenario_edits;
mod table;
mod tasks;

pub use completion::{Names, complete};
pub use table::{COMMANDS, Command, reference};
