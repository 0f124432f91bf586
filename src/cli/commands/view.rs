//! `runner view`: shows a run's log as an animated page.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::view::{DrawnRun, ViewServer, ViewableRuns, file_page, pack};
use clap::Args;

use crate::cli::Exit;
use crate::cli::arguments::numbers;
use crate::cli::signals::on_termination_signal;
use crate::cli::terminal::{complain, complain_of, plural, print};

/// Arguments of `view`.
#[derive(Args, Debug)]
pub struct View {
    /// A log, the folder of a run, or a folder of results
    #[arg(value_name = "LOG|FOLDER", default_value = "results")]
    what: PathBuf,
    /// Loopback port to serve on [default: any free port]
    #[arg(long, value_name = "N", conflicts_with = "output")]
    port: Option<u16>,
    /// Open the page in the browser
    #[arg(long, conflicts_with = "output")]
    open: bool,
    /// Write one self-contained page instead of serving
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
    /// Show at most this many ticks per simulated second, Hz [default: all logged ticks]
    #[arg(long, value_name = "HZ", value_parser = numbers::positive, allow_negative_numbers = true)]
    rate: Option<f64>,
}

impl View {
    /// Serves, or writes the page.
    pub fn execute(self) -> Result<Exit, Exit> {
        let (runs, skipped) = ViewableRuns::find(&self.what).map_err(refuse)?;
        skipped.iter().for_each(|error| complain(&format!("warning: passed over: {error}")));
        if runs.runs().is_empty() {
            let what = self.what.display();
            complain(&format!(
                "nothing selected: {} in {what}, none of which left a log",
                plural(runs.without_log(), "run")
            ));
            return Err(Exit::Nothing);
        }
        match &self.output {
            Some(file) => self.write(&runs, file),
            None => self.serve(runs),
        }
    }

    fn write(&self, runs: &ViewableRuns, file: &Path) -> Result<Exit, Exit> {
        let [run] = runs.runs() else {
            let (what, n) = (self.what.display(), runs.runs().len());
            return Err(refuse(format!("{what} holds {n} runs; a page holds one: name its folder")));
        };
        if matches!((file.canonicalize(), run.log.canonicalize()), (Ok(a), Ok(b)) if a == b) {
            return Err(refuse(format!("{} is the log itself: choose another file to write", file.display())));
        }
        let page = file_page(&run.title(), &pack(&DrawnRun::read(&run.log).map_err(refuse)?, self.rate));
        crate::view::write_page(file, &page).map_err(|error| {
            refuse(&error);
            Exit::of_writing(&error)
        })?;
        complain(&format!("{}: {:.1} MB", file.display(), page.len() as f64 * 1e-6));
        Ok(Exit::Success)
    }

    fn serve(self, runs: ViewableRuns) -> Result<Exit, Exit> {
        // A single log is checked before serving; others are read when selected.
        if let [run] = runs.runs() {
            DrawnRun::read(&run.log).map_err(refuse)?;
        }
        let count = runs.runs().len();
        let port = self.port.unwrap_or(0);
        let server = ViewServer::new(runs, self.rate, port)
            .map_err(|error| refuse(format!("cannot listen on port {port} of 127.0.0.1: {error}")))?;
        let stopper = server.stopper();
        on_termination_signal(move |_| stopper.stop());
        let address = format!("http://{}/", server.address());
        print(&format!("{address}\n"))?;
        complain(&format!("{} shown to this machine only; Ctrl-C ends", plural(count, "run")));
        if self.open {
            open(&address);
        }
        server.run();
        Ok(Exit::Success)
    }
}

/// Opens an address with the system's program for it.
fn open(address: &str) {
    let program = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let mut command = Command::new(program);
    command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Err(error) = command.spawn() {
        complain(&format!("warning: cannot start {program}: {error}; open the address yourself"));
    }
}

fn refuse(why: impl Display) -> Exit {
    complain_of(why);
    Exit::Invalid
}
