//! Command line of `runner`: `commands/` has one file per command, `arguments/` what commands
//! share.
//!
//! Imports: `text`, `files`, `web`, `robot`, `collision`, `scenario`, `sim`, `log`, `results`,
//! `report`, `export`, `remote`, `live`, `batch`, `replay`, `view`, `submit`, `console`,
//! `schema_page`. Used by: the program.

mod arguments;
mod colour;
mod commands;
mod exit;
pub mod signals;
mod terminal;

use std::io::Write;

use clap::{Parser, Subcommand};

use commands::{
    check, compare, completions, console, export, inspect, list, man, merge, motor_server, replay, report, run,
    salvage, schema, submit, view,
};
pub use exit::Exit;

/// Run scenarios of legged-robot contact: exact Coulomb friction against faster methods.
///
/// Without a command the arguments are scenarios to run.
#[derive(Parser, Debug)]
#[command(name = "runner", version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(arg_required_else_help = true, after_help = exit::help("run"))]
pub struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::Run,
    /// Whether errors and help have colours
    // `colour` reads it before parsing; here it is only checked and described.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = colour::Colour::Auto)]
    color: colour::Colour,
}

/// Sets colours from the arguments and the environment.
pub fn decide_colours() {
    colour::decide(std::env::args_os().skip(1));
}

/// Commands.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Simulate scenarios, evaluate expectations, write logs and a summary
    #[command(after_help = exit::help("run"))]
    Run(run::Run),
    /// Validate scenarios and robots and expand sweeps; simulate nothing, write nothing
    #[command(after_help = exit::help("check"))]
    Check(check::Check),
    /// Show the runs that scenarios expand to, with their keys
    #[command(after_help = exit::help("list"))]
    List(list::List),
    /// Describe a robot: degrees of freedom, masses, joints, soles, ignored elements
    #[command(after_help = exit::help("inspect"))]
    Inspect(inspect::Inspect),
    /// Rewrite summary and report.html from the records in a folder of results
    #[command(after_help = exit::help("report"))]
    Report(report::Report),
    /// Merge the results of shards into those of one batch
    #[command(after_help = exit::help("merge"))]
    Merge(merge::Merge),
    /// Run a batch as a cluster job array and merge its results
    #[command(after_help = submit::help())]
    Submit(submit::Submit),
    /// Report differences between two results
    #[command(after_help = exit::help("compare"))]
    Compare(compare::Compare),
    /// Write a log's time series as CSV, Parquet or columns of text
    #[command(after_help = exit::help("export"))]
    Export(export::Export),
    /// Recover the readable part of damaged or unfinished logs
    #[command(after_help = exit::help("salvage"))]
    Salvage(salvage::Salvage),
    /// Re-run from records and compare bit for bit
    #[command(after_help = exit::help("replay"))]
    Replay(replay::Replay),
    /// Simulate the robot for tasks in another process, over UDP
    #[command(after_help = exit::help("motor-server"))]
    MotorServer(motor_server::Server),
    /// Simulate a scenario interactively: step it, change it and inspect it
    #[command(after_help = exit::help("console"))]
    Console(console::Console),
    /// Play a run's log in three dimensions in the browser
    #[command(after_help = exit::help("view"))]
    View(view::View),
    /// Print the JSON Schema of a file format or of the messages
    #[command(after_help = exit::help("schema"))]
    Schema(schema::Schema),
    /// Print a script that completes command lines in a shell
    #[command(after_help = exit::help("completions"))]
    Completions(completions::Completions),
    /// Print the manual page, or write one for each command
    #[command(after_help = exit::help("man"))]
    Man(man::Manual),
}

impl Arguments {
    /// Parses the command line. After help, version or a usage error, returns the exit code.
    pub fn typed() -> Result<Self, Exit> {
        Self::try_parse().map_err(|error| {
            let outcome = error.print().and_then(|()| std::io::stdout().flush());
            match error.use_stderr() {
                true => Exit::Invalid,
                false => terminal::written(outcome).err().unwrap_or(Exit::Success),
            }
        })
    }

    /// The given command; `run` by default.
    pub fn into_command(self) -> Command {
        self.command.unwrap_or(Command::Run(self.run))
    }
}
