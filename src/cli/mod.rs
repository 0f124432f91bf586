//! Command line of `runner`: `commands/` has one file per command, `arguments/` what commands
//! share.
//!
//! Imports: `text`, `input`, `robot`, `sim`, `scenario`, `files`, `convert`, `log`, `results`,
//! `remote`, `batch`, `web`, `merge`, `compare`, `report`, `export`, `live`, `replay`, `view`,
//! `schema_page`, `console`, `collision`, `submit`, `fit`, `history`. Used by: the crate root.

// Comments of arguments are help texts for a terminal.
#![allow(rustdoc::bare_urls)]

mod arguments;
mod colour;
mod commands;
mod exit;
mod program;
mod signals;
mod terminal;

use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;

use clap::{CommandFactory, Parser, Subcommand};

use commands::{
    check, compare, completions, console, convert, export, fit, inspect, list, man, merge, motor_server, replay,
    report, run, salvage, schema, submit, view,
};
pub use exit::Exit;

/// Run scenarios of legged-robot contact: exact Coulomb friction against faster methods.
///
/// Without a command the arguments are scenarios to run.
#[derive(Parser, Debug)]
#[command(name = "runner", version, args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(arg_required_else_help = true, after_help = exit::help("run"))]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: run::Run,
    /// Whether errors and help have colours
    // `colour` reads it before parsing; here it is only checked and described.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = colour::Colour::Auto)]
    color: colour::Colour,
}

/// Executes the command line of this process.
pub fn main() -> Exit {
    execute(std::env::args_os().collect())
}

/// Executes a command line for a launcher of another kind, such as a Python interpreter. `launcher` is
/// the path that starts it again, which jobs of a cluster need.
pub fn main_of_launcher(launcher: PathBuf, arguments: Vec<OsString>) -> Exit {
    program::set(launcher.clone());
    execute(std::iter::once(launcher.into_os_string()).chain(arguments).collect())
}

/// Executes a command line, which begins with the program's name.
fn execute(line: Vec<OsString>) -> Exit {
    colour::decide(line.iter().skip(1).cloned());
    signals::handle_file_size_limit();
    let done = match Arguments::parsed(line) {
        Ok(arguments) => arguments.command.unwrap_or(Command::Run(arguments.run)).execute(),
        Err(exit) => return exit,
    };
    done.unwrap_or_else(|failed| failed)
}

/// Commands.
#[derive(Subcommand, Debug)]
enum Command {
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
    /// Write a robot as URDF or MJCF
    #[command(after_help = exit::help("convert"))]
    Convert(convert::Convert),
    /// Rewrite summary and report.html from the records in a folder of results
    #[command(after_help = exit::help("report"))]
    Report(report::Report),
    /// Merge the results of shards into those of one batch
    #[command(after_help = exit::help("merge"))]
    Merge(merge::Merge),
    /// Run a batch as a cluster job array and merge its results
    #[command(after_help = submit::help())]
    Submit(submit::Submit),
    /// Report differences between results, and keep a history of them
    #[command(after_help = exit::help("compare"))]
    Compare(compare::Compare),
    /// Write a log as CSV, Parquet or columns of text, or as a ROS 2 bag
    #[command(after_help = exit::help("export"))]
    Export(export::Export),
    /// Fit parameters of a scenario to recorded data by least squares
    #[command(after_help = exit::help("fit"))]
    Fit(fit::FitCommand),
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
    /// Parses a command line. After help, version or a usage error, returns the exit code.
    fn parsed(line: Vec<OsString>) -> Result<Self, Exit> {
        Self::try_parse_from(line).map_err(|error| {
            let outcome = error.print().and_then(|()| std::io::stdout().flush());
            match error.use_stderr() {
                true => Exit::Invalid,
                false => terminal::written(outcome).err().unwrap_or(Exit::Success),
            }
        })
    }
}

impl Command {
    fn execute(self) -> Result<Exit, Exit> {
        match self {
            Command::Run(run) => run.execute(),
            Command::Check(check) => check.execute(),
            Command::List(list) => list.execute(),
            Command::Inspect(inspect) => inspect.execute(),
            Command::Convert(convert) => convert.execute(),
            Command::Report(report) => report.execute(),
            Command::Merge(merge) => merge.execute(),
            Command::Submit(submit) => submit.execute(),
            Command::Compare(compare) => compare.execute(),
            Command::Export(export) => export.execute(),
            Command::Fit(fit) => fit.execute(),
            Command::Salvage(salvage) => salvage.execute(),
            Command::Replay(replay) => replay.execute(),
            Command::MotorServer(server) => server.execute(),
            Command::Console(console) => console.execute(),
            Command::View(view) => view.execute(),
            Command::Schema(schema) => schema.execute(),
            Command::Completions(completions) => completions.execute(Arguments::command()),
            Command::Man(manual) => manual.execute(Arguments::command()),
        }
    }
}
