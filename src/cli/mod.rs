//! Command line of `runner`: one file per command.

mod check;
mod colour;
mod compare;
mod completions;
mod console;
mod each;
mod exit;
mod export;
mod inputs;
mod inspect;
mod list;
mod live;
mod machine;
mod man;
mod merge;
mod motor_server;
mod numbers;
mod prepare;
mod replay;
mod report;
mod run;
mod schema;
mod signals;
mod submit;
mod terminal;
mod view;

use std::io::Write;

use clap::{Parser, Subcommand};

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
    /// When errors and help have colours
    // `colour` reads it before parsing; here it is only checked and described.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = colour::Colour::Auto)]
    color: colour::Colour,
}

/// Sets colours from the arguments and the environment.
pub fn decide_colours() {
    colour::decide(std::env::args_os().skip(1));
}

/// What can be done.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Simulate scenarios, judge them, leave logs and a summary
    #[command(after_help = exit::help("run"))]
    Run(run::Run),
    /// Validate scenarios and robots and expand sweeps; step nothing, write nothing
    #[command(after_help = exit::help("check"))]
    Check(check::Check),
    /// Show the runs that scenarios expand to, with their keys
    #[command(after_help = exit::help("list"))]
    List(list::List),
    /// Describe a robot: degrees of freedom, masses, joints, soles, what was ignored
    #[command(after_help = exit::help("inspect"))]
    Inspect(inspect::Inspect),
    /// Write summary and report.html anew from the records of a folder of results
    #[command(after_help = exit::help("report"))]
    Report(report::Report),
    /// Put the results of shards together to those of one batch
    #[command(after_help = exit::help("merge"))]
    Merge(merge::Merge),
    /// Share a batch out as jobs of a cluster, merged when they have ended
    #[command(after_help = submit::help())]
    Submit(submit::Submit),
    /// Say what differs between two results
    #[command(after_help = exit::help("compare"))]
    Compare(compare::Compare),
    /// Write a log's time series as CSV, Parquet or columns of text
    #[command(after_help = exit::help("export"))]
    Export(export::Export),
    /// Run again from records and compare bit for bit
    #[command(after_help = exit::help("replay"))]
    Replay(replay::Replay),
    /// Be the robot of tasks that run somewhere else, over UDP
    #[command(after_help = exit::help("motor-server"))]
    MotorServer(motor_server::Server),
    /// Simulate a scenario step by step, change it and ask about it while it goes on
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
        Self::try_parse().map_err(|told| {
            let outcome = told.print().and_then(|()| std::io::stdout().flush());
            match told.use_stderr() {
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
