//! A session at the console: a scenario that is simulated step by step and changed while it goes on.
//!
//! ```text
//! a line -> words -> the table of commands -> the scenario with one entry more -> read and built as any scenario
//!                                                                              -> the simulation goes on as that one's
//! ```
//!
//! Whatever changes the motion is an entry of the scenario: an event, a task, a force, at the control tick at which it was typed.
//! So the session is a scenario at any time, and what is saved of it replays to the same bits.

mod commands;
mod complete;
mod cursor;
mod document;
mod edit;
mod error;
mod motion;
mod player;
mod query;
mod recording;
mod session;
mod shown;
mod tap;
mod tasks;
mod words;

pub use commands::{COMMANDS, Command, reference};
pub use complete::{Names, complete};
pub use error::ConsoleError;
pub use session::Session;
