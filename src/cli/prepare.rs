//! What commands about scenarios share: which ones, with what changes, checked and expanded.

use std::path::PathBuf;

use clap::Args;
use stiction::batch::{self, Plan, Severity, Shard};
use stiction::scenario::{DEFAULT_MAX_RUNS, parse_override};

use super::{Exit, inputs, terminal};

/// Scenarios and what is changed in all of them.
#[derive(Args, Debug)]
pub struct Scenarios {
    /// Scenario files; a folder means every .toml file in it
    #[arg(required = true, value_name = "SCENARIO")]
    files: Vec<PathBuf>,
    /// Replace a value of every scenario, such as contact.method=one-step; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = parse_override)]
    overrides: Vec<(String, toml::Value)>,
    /// Refuse to expand to more runs than this
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_RUNS)]
    max_runs: usize,
    /// Only part I of N equal parts, such as 3/8; `env` asks the job array of Slurm or Kubernetes that this is in
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Take warnings for errors
    #[arg(long)]
    strict: bool,
}

impl Scenarios {
    /// Loads, expands and checks everything; shows what there is to say from this severity on.
    pub fn prepare(&self, least: Severity) -> Result<Plan, Exit> {
        let files = inputs::scenario_files(&self.files)?;
        let (mut plan, findings) = match batch::prepare(&files, &self.overrides, self.max_runs) {
            Ok(prepared) => prepared,
            Err(findings) => {
                terminal::show(&findings, least);
                return Err(Exit::Invalid);
            }
        };
        terminal::show(&findings, least);
        if self.strict && findings.count(Severity::Warning) > 0 {
            terminal::complain("error: with --strict, warnings are errors");
            return Err(Exit::Invalid);
        }
        if plan.runs() == 0 {
            terminal::complain("nothing selected: the scenarios expand to no runs");
            return Err(Exit::Nothing);
        }
        if let Some(shard) = self.shard {
            let all = plan.runs();
            plan.take_shard(shard);
            terminal::complain(&format!("shard {shard}: {} of {all}", terminal::plural(plan.runs(), "run")));
        }
        Ok(plan)
    }
}
