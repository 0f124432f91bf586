//! `runner schema`: formats for editors and other programs.

use clap::{Args, ValueEnum};
use stiction::{batch, robot, scenario};

use super::{Exit, terminal};

/// Arguments of `schema`.
#[derive(Args, Debug)]
pub struct Schema {
    /// Which format
    #[arg(value_enum)]
    format: Format,
}

/// A format.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Format {
    /// A scenario file
    Scenario,
    /// A robot file
    Robot,
    /// Messages of `--message-format json`, each line
    Messages,
}

impl Schema {
    /// Prints the format's JSON Schema.
    pub fn execute(self) -> Result<Exit, Exit> {
        let schema = match self.format {
            Format::Scenario => scenario::schema(),
            Format::Robot => robot::schema(),
            Format::Messages => batch::message_schema(),
        };
        terminal::print(&format!("{schema:#}\n"))?;
        Ok(Exit::Success)
    }
}
