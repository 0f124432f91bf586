//! Options that apply to each run, local or submitted.

use std::time::Duration;

use crate::sim::Problems;
use clap::{Args, ValueEnum};

use crate::cli::arguments::numbers;

/// Options of each run.
#[derive(Args, Debug)]
pub struct Each {
    /// Do not repeat runs for timing
    #[arg(long)]
    pub no_timing: bool,
    /// Write no logs
    #[arg(long)]
    pub no_log: bool,
    /// Wait until the files of each run are on the storage device (fsync): safe against power
    /// failures, slower
    #[arg(long)]
    pub durable: bool,
    /// Wall-clock limit of each run
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_negative_numbers = true)]
    pub timeout: Option<Duration>,
    /// Report runs that take longer than this, while they run and at the end
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_negative_numbers = true)]
    pub slow: Option<Duration>,
    /// Write contact problems as JSON: those without a valid state, or all; at most 100 per run
    #[arg(long, value_name = "WHICH", num_args = 0..=1, require_equals = true, default_missing_value = "inconsistent")]
    dump_problems: Option<Which>,
}

/// Contact problems to write.
#[derive(ValueEnum, Clone, Copy, Debug)]
pub enum Which {
    /// Selections in which no state was valid
    Inconsistent,
    /// Every selection
    All,
}

impl Which {
    /// The contact problems to write.
    pub fn problems(requested: Option<Which>) -> Problems {
        match requested {
            None => Problems::None,
            Some(Which::Inconsistent) => Problems::Inconsistent,
            Some(Which::All) => Problems::All,
        }
    }
}

impl Each {
    /// The contact problems to write.
    pub fn problems(&self) -> Problems {
        Which::problems(self.dump_problems)
    }

    /// The options as arguments of `runner run`.
    pub fn to_arguments(&self) -> Vec<String> {
        let flags = [(self.no_timing, "--no-timing"), (self.no_log, "--no-log"), (self.durable, "--durable")];
        let flags = flags.into_iter().filter(|(set, _)| *set).map(|(_, flag)| flag.to_owned());
        let times = [("--timeout", self.timeout), ("--slow", self.slow)];
        let times = times.into_iter().filter_map(|(name, time)| Some(format!("{name}={}", time?.as_secs_f64())));
        let problems = self.dump_problems.map(|which| match which {
            Which::Inconsistent => "--dump-problems=inconsistent".to_owned(),
            Which::All => "--dump-problems=all".to_owned(),
        });
        flags.chain(times).chain(problems).collect()
    }
}
