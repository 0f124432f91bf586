//! `runner check`: everything that happens before the first step.

use clap::Args;
use stiction::batch::Severity;

use super::Exit;
use super::prepare::Scenarios;
use super::terminal::{counted, plural, print};

/// Arguments of `check`.
#[derive(Args, Debug)]
pub struct Check {
    #[command(flatten)]
    scenarios: Scenarios,
}

impl Check {
    /// Says what is wrong, else what there is.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(Severity::Note)?;
        let mut text = String::new();
        for file in &plan.files {
            let runs = plan.runs_of(file);
            text += &format!("{}: {}\n", file.display(), plural(runs, "run"));
        }
        let runs = counted(plan.runs(), plan.references());
        text += &format!("all good: {}, {runs}\n", plural(plan.files.len(), "scenario"));
        print(&text)?;
        Ok(Exit::Success)
    }
}
