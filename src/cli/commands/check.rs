//! `runner check`: validates scenarios without simulating them.

use std::time::Duration;

use crate::batch::{CheckFinished, Message, Plan};
use crate::text::visible::visible_path;
use clap::Args;

use crate::cli::Exit;
use crate::cli::arguments::message_format::{Format, MessageFormat};
use crate::cli::arguments::numbers;
use crate::cli::arguments::selection::Scenarios;
use crate::cli::terminal::{counted, plural, print};

/// Arguments of `check`.
#[derive(Args, Debug)]
pub struct Check {
    #[command(flatten)]
    scenarios: Scenarios,
    /// Wall-clock limit for the scripts of each run to be ready
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = numbers::seconds, allow_negative_numbers = true)]
    timeout: Duration,
    #[command(flatten)]
    format: Format,
}

impl Check {
    /// Reports errors, or a summary if there are none.
    pub fn execute(self) -> Result<Exit, Exit> {
        let format = self.format.message_format;
        let plan = self.scenarios.prepare_within(usize::MAX, format, self.timeout);
        let exit = plan.as_ref().map_or_else(|exit| *exit, |_| Exit::Success);
        let mut last = CheckFinished { exit_code: exit as u8, ..CheckFinished::default() };
        if let Ok(plan) = &plan {
            last.files = plan.files.iter().map(|file| file.display().to_string()).collect();
            (last.runs, last.references) = (plan.runs(), plan.references());
        }
        format.emit(Message::CheckFinished(last))?;
        if format == MessageFormat::Human {
            print(&summary(&plan?))?;
        }
        Ok(exit)
    }
}

fn summary(plan: &Plan) -> String {
    let mut text = String::new();
    for file in &plan.files {
        let runs = plan.runs_of(file);
        text += &match plan.most_probes_of(file) {
            Some(most) => {
                let searches = format!("{most} for each of {}", plural(runs / most, "combination"));
                format!("{}: at most {}, {searches}\n", visible_path(file), plural(runs, "run"))
            }
            None => format!("{}: {}\n", visible_path(file), plural(runs, "run")),
        };
    }
    let runs = counted(plan.runs(), plan.references());
    let at_most = if plan.has_search() { "at most " } else { "" };
    text + &format!("all good: {}, {at_most}{runs}\n", plural(plan.files.len(), "scenario"))
}
