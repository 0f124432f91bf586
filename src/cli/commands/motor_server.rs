//! `runner motor-server`: simulates a scenario's robot and floor; tasks in another process command
//! it.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use crate::batch::{Batch, NoListener, Options, Progress, simulate_with_command_source};
use crate::remote::{Address, Impairment, KeyFile, MotorServer, Pace};
use crate::report::batch_page;
use crate::sim::CommandSource;
use crate::sim::{Problems, RunError};
use clap::{Args, ValueHint};

use crate::cli::Exit;
use crate::cli::arguments::link::{address, pace};
use crate::cli::arguments::live::{Live, print_notes};
use crate::cli::arguments::message_format::MessageFormat;
use crate::cli::arguments::numbers::seconds;
use crate::cli::arguments::selection::{Scenarios, only};
use crate::cli::commands::run::{Shows, summary};
use crate::cli::signals::on_termination_signal;
use crate::cli::terminal::{complain, complain_of, print};

/// Arguments of `motor-server`.
#[derive(Args, Debug)]
pub struct Server {
    #[command(flatten)]
    scenarios: Scenarios,
    /// Address to listen on; port 0 selects a free one, which is printed
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:4747", value_parser = address)]
    bind: SocketAddr,
    /// Pace of the robot's clock: `free` waits for the control of each tick; `realtime` or a factor
    /// such as 0.5 does not wait
    #[arg(long, value_name = "PACE", default_value = "free", value_parser = pace)]
    pace: Pace,
    /// File with the secret that both sides share; required unless the address is on loopback
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    key: Option<PathBuf>,
    /// How long to wait for a client [default: unlimited]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    wait: Option<Duration>,
    /// Impair sent packets, such as loss=0.2,duplicate=0.1,reorder=0.1,delay=0.2:0.005,seed=1:
    /// shares of the packets, the delay with its largest duration in seconds
    #[arg(long, value_name = "WHAT", value_parser = Impairment::from_str)]
    impair: Option<Impairment>,
    /// Folder of the results
    #[arg(short, long, value_name = "DIR", default_value = "results-robot", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Write no log
    #[arg(long)]
    no_log: bool,
    #[command(flatten)]
    live: Live,
}

impl Server {
    /// Waits for a client, simulates, writes results.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(usize::MAX, MessageFormat::Human)?;
        only(&plan)?;
        let refuse = |error: &dyn std::error::Error| {
            complain_of(error);
            Exit::Invalid
        };
        let file = self.key.as_deref().map(KeyFile::read).transpose().map_err(|error| refuse(&error))?;
        let warning = file.as_ref().and_then(|file| file.warning.as_ref());
        warning.iter().for_each(|warning| complain(&format!("warning: {warning}")));
        let address = Address { at: self.bind, key: file.map(|file| file.key) };
        address.check().map_err(|error| refuse(&error))?;
        let clients = self.live.start(&plan, None).map_err(|error| refuse(&error))?;
        let options = Options {
            output: self.output.clone(),
            jobs: 1,
            log: !self.no_log,
            timeout: None,
            max_fail: None,
            slow: None,
            problems: Problems::None,
            timing: false,
            resume: false,
        };
        let batch = Batch::new(plan, options, batch_page).map_err(|error| refuse(&error))?;
        let interrupter = batch.interrupter();
        // A run commanded from outside may have no end, so the first signal ends it.
        let interruption = on_termination_signal(move |_| (0..2).for_each(|_| interrupter.interrupt()));
        let report =
            batch.run_with_listener(Progress::on_stderr(0, false), &mut NoListener, &|job, outputs, cancel| {
                simulate_with_command_source(job, outputs, cancel, clients.as_deref(), |setup, cancelled| {
                    let rate = job.run.scenario.control.rate;
                    let mut server = MotorServer::bind(
                        &address,
                        &setup.model,
                        &setup.tasks.command,
                        (rate, self.pace),
                        self.impair,
                        cancelled,
                    )?;
                    if let Some(at) = server.local() {
                        complain(&format!("{} at {at}", setup.model.name));
                    }
                    server.wait(self.wait).map_err(RunError::from)?;
                    Ok(Box::new(server) as Box<dyn CommandSource>)
                })
            });
        print_notes(clients.as_deref());
        let report = report.map_err(|error| {
            refuse(&error);
            Exit::Unfinished
        })?;
        print(&summary(&report, Shows::default()))?;
        Ok(Exit::of_batch(&report, interruption.exit()))
    }
}
