//! `runner schema`: prints schemas of the formats for editors and other programs.

use clap::{Args, ValueEnum};
use stiction::schema_page::{Notation, page};
use stiction::{batch, robot, scenario};

use super::{Exit, terminal};

/// Arguments of `schema`.
#[derive(Args, Debug)]
pub struct Schema {
    /// Which format
    #[arg(value_enum)]
    format: Format,
    /// Print a reference page in Markdown, made of the same types
    #[arg(long)]
    markdown: bool,
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
    /// Prints the format's JSON Schema, or a page about it.
    pub fn execute(self) -> Result<Exit, Exit> {
        let schema = match self.format {
            Format::Scenario => scenario::schema(),
            Format::Robot => robot::schema(),
            Format::Messages => batch::message_schema(),
        };
        let text = if self.markdown { self.format.page(&schema) } else { format!("{schema:#}\n") };
        terminal::print(&text)?;
        Ok(Exit::Success)
    }
}

impl Format {
    fn page(self, schema: &serde_json::Value) -> String {
        let (notation, heading, beside) = match self {
            Format::Scenario => (
                Notation::Toml,
                "Scenario files: every key",
                "[scenario.md](../scenario.md) explains the same with examples, which settings go together, and the rules that no type \
                 tells.",
            ),
            Format::Robot => (
                Notation::Toml,
                "Robot files: every key",
                "[robots.md](../robots.md) explains the same with examples and the rules that no type tells.",
            ),
            Format::Messages => (
                Notation::Json,
                "Messages of `--message-format json`",
                "One line of JSON for each message; [ci.md](../ci.md) shows them in use.",
            ),
        };
        let name = self.to_possible_value().map(|value| value.get_name().to_string()).unwrap_or_default();
        let introduction = format!(
            "Made by `runner schema {name} --markdown` from the types that the program reads and writes, and tested to be up to date. \
             {beside}"
        );
        page(schema, notation, heading, &introduction)
    }
}
