//! `runner console`: simulates one run interactively or from a script of console commands.

mod command_script;
mod interactive;

use std::fs::File;
use std::io::{BufReader, IsTerminal};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::console::{ConsoleError, Session};
use crate::files::{OutputKind, check_replaceable};
use crate::remote::Pace;
use clap::{Args, ValueHint};

use crate::cli::arguments::link;
use crate::cli::arguments::live::Live;
use crate::cli::arguments::message_format::MessageFormat;
use crate::cli::arguments::numbers;
use crate::cli::arguments::selection::{Selection, only};
use crate::cli::signals::{FirstSignal, on_termination_signal};
use crate::cli::terminal::{complain, complain_drawn, complain_of, print};
use crate::cli::{Exit, colour};
use command_script::LineReader;

/// Longest session by default, s, unless the scenario is longer.
const DEFAULT_DURATION: f64 = 600.0;

/// Arguments of `console`.
#[derive(Args, Debug)]
pub struct Console {
    #[command(flatten)]
    scenarios: Selection,
    /// Read commands from a file; `-` is standard input
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: Option<PathBuf>,
    /// Execute this line first; may be repeated
    #[arg(short = 'c', long = "command", value_name = "LINE")]
    commands: Vec<String>,
    /// Simulated time per wall-clock time: `free`, `realtime` or a factor [default: realtime on a
    /// terminal, else free]
    #[arg(long, value_name = "RATE", value_parser = link::pace)]
    rate: Option<Pace>,
    /// Longest simulated time [default: the scenario's duration, at least 600]
    #[arg(long, value_name = "SECONDS", value_parser = numbers::positive, allow_negative_numbers = true)]
    duration: Option<f64>,
    #[command(flatten)]
    live: Live,
    /// Write the session as a scenario when it ends
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    save: Option<PathBuf>,
}

impl Console {
    /// Executes the lines of all sources in turn.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(usize::MAX, MessageFormat::Human)?;
        only(&plan)?;
        if let Some(path) = &self.save {
            // Check before a long session whose result could not be saved.
            check_replaceable(path, OutputKind::Session).map_err(|error| report_error(&error.into()))?;
        }
        let person = self.file.is_none() && std::io::stdin().is_terminal();
        let pace = match self.rate {
            Some(Pace::Free) => None,
            Some(Pace::Times(times)) => Some(times),
            None => person.then_some(1.0),
        };
        let live_clients = self.live.start(&plan, None).map_err(|error| {
            complain_of(error);
            Exit::Invalid
        })?;
        let job = plan.job(0);
        let end = self.duration.unwrap_or(job.run.scenario.duration.max(DEFAULT_DURATION));
        let mut session = Session::new(job, end, pace).map_err(|error| report_error(&error))?;
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = interrupted.clone();
        session.cancel_on(interrupted.clone());
        let first_signal = on_termination_signal(move |_| flag.store(true, Ordering::Relaxed));
        if let Some(live_clients) = live_clients {
            session.stream_to(live_clients, &interrupted).map_err(|error| report_error(&error))?;
        }
        let stop = Interruption { interrupted, first_signal };
        let done = self.lines(&mut session, person, &stop);
        session.end_stream().iter().for_each(|line| complain(line));
        if let Some(path) = &self.save {
            // Save after any outcome.
            let saved = session.save_session(path).map_err(|error| report_error(&error));
            saved.map(|saved| print(&saved))??;
        }
        done
    }

    fn lines(&self, session: &mut Session, person: bool, stop: &Interruption) -> Result<Exit, Exit> {
        let typed = self.commands.iter().map(|line| Ok(line.clone()));
        let exit = command_script::execute_lines(session, "--command", typed, stop)?;
        if session.has_ended() || !self.commands.is_empty() && self.file.is_none() && !person {
            return Ok(exit);
        }
        let more = if person { interactive::execute_lines(session, stop) } else { self.script(session, stop) };
        Ok(worse(exit, more?))
    }

    fn script(&self, session: &mut Session, stop: &Interruption) -> Result<Exit, Exit> {
        let file = self.file.clone().filter(|path| path.as_os_str() != "-");
        let from = file.as_ref().map_or("standard input".into(), |path| path.display().to_string());
        let lines = match file {
            Some(path) => LineReader::new(move || File::open(path).map(BufReader::new), stop),
            None => LineReader::new(|| Ok(BufReader::new(std::io::stdin())), stop),
        };
        let lines = lines.map_err(|error| {
            complain_of(format!("cannot read {from}: {error}"));
            Exit::Unfinished
        })?;
        command_script::execute_lines(session, &from, lines, stop)
    }
}

/// Interruption of the program by a signal.
struct Interruption {
    interrupted: Arc<AtomicBool>,
    first_signal: FirstSignal,
}

impl Interruption {
    fn exit(&self) -> Option<Exit> {
        self.interrupted.load(Ordering::Relaxed).then(|| self.first_signal.exit())
    }
}

/// Exit code that reports both of two outcomes.
fn worse(a: Exit, b: Exit) -> Exit {
    if b == Exit::Success { a } else { b }
}

/// Exit code of a script that ends with an error.
fn exit_of(error: &ConsoleError) -> Exit {
    match error {
        ConsoleError::Expectation(_) => Exit::Failed,
        ConsoleError::Terminated { .. } => Exit::Unfinished,
        ConsoleError::Record(cause) => Exit::of_writing(cause),
        ConsoleError::Export(crate::export::ExportError::Record(cause)) => Exit::of_writing(cause),
        ConsoleError::Io { source, .. } => Exit::of_writing(source),
        ConsoleError::Usage(_) | ConsoleError::Scenario(_) | ConsoleError::Log(_) | ConsoleError::Export(_) => {
            Exit::Invalid
        }
    }
}

fn report_error(error: &ConsoleError) -> Exit {
    complain_drawn(&error.render(colour::on_stderr()));
    exit_of(error)
}
