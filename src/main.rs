//! `runner`: simulates scenarios of legged-robot contact and writes logs, verdicts and a summary.

#![forbid(unsafe_code)]

mod cli;

use clap::CommandFactory;
use cli::{Arguments, Command, Exit};

fn main() -> Exit {
    cli::decide_colours();
    cli::signals::handle_file_size_limit();
    let typed = match Arguments::typed() {
        Ok(arguments) => arguments.into_command(),
        Err(exit) => return exit,
    };
    let done = match typed {
        Command::Run(run) => run.execute(),
        Command::Check(check) => check.execute(),
        Command::List(list) => list.execute(),
        Command::Inspect(inspect) => inspect.execute(),
        Command::Report(report) => report.execute(),
        Command::Merge(merge) => merge.execute(),
        Command::Submit(submit) => submit.execute(),
        Command::Compare(compare) => compare.execute(),
        Command::Export(export) => export.execute(),
        Command::Salvage(salvage) => salvage.execute(),
        Command::Replay(replay) => replay.execute(),
        Command::MotorServer(server) => server.execute(),
        Command::Console(console) => console.execute(),
        Command::View(view) => view.execute(),
        Command::Schema(schema) => schema.execute(),
        Command::Completions(completions) => completions.execute(Arguments::command()),
        Command::Man(manual) => manual.execute(Arguments::command()),
    };
    done.unwrap_or_else(|failed| failed)
}
