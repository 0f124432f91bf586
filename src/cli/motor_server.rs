//! `runner motor-server`: a scenario's robot and floor, driven by tasks that run somewhere else.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::{Args, ValueHint};
use stiction::batch::{Batch, NoListener, Options, Progress, simulate_with_command_source};
use stiction::remote::{Address, Impairment, MotorServer, Pace, read_key};
use stiction::sim::CommandSource;
use stiction::sim::{Problems, RunError};

use super::Exit;
use super::live::{Live, tell};
use super::machine::MessageFormat;
use super::numbers::seconds;
use super::prepare::{Scenarios, only};
use super::run::{Shows, summary};
use super::signals::when_asked_to_end;
use super::terminal::{complain, complain_of, print};

/// Arguments of `motor-server`.
#[derive(Args, Debug)]
pub struct Server {
    #[command(flatten)]
    scenarios: Scenarios,
    /// Address to listen on; port 0 takes a free one, which is told
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:4747", value_parser = address)]
    bind: SocketAddr,
    /// The robot's clock: `free` waits for the control of each tick, `realtime` and factors of it such as 0.5 do not wait
    #[arg(long, value_name = "PACE", default_value = "free", value_parser = pace)]
    pace: Pace,
    /// File with the secret that both sides have; needed unless the address is on loopback
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    key: Option<PathBuf>,
    /// How long to wait for tasks [default: until they come]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    wait: Option<Duration>,
    /// Spoil what is sent, such as loss=0.2,duplicate=0.1,reorder=0.1,delay=0.2:0.005,seed=1: shares of the packets, the delay's
    /// with its greatest length in seconds
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

/// An address with a port.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let mut found = text.to_socket_addrs().map_err(|_| "an address with a port is wanted, such as 127.0.0.1:4747")?;
    found.next().ok_or_else(|| "nobody has this name".into())
}

/// How fast a clock goes.
pub fn pace(text: &str) -> Result<Pace, String> {
    match text {
        "free" => Ok(Pace::Free),
        "realtime" => Ok(Pace::Times(1.0)),
        number => {
            let times = number.parse().ok().filter(|times: &f64| times.is_finite() && *times > 0.0);
            times.map(Pace::Times).ok_or_else(|| "`free`, `realtime` or a number above 0 is wanted".into())
        }
    }
}

impl Server {
    /// Listens, simulates, records.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(usize::MAX, MessageFormat::Human)?;
        only(&plan)?;
        let refuse = |error: &dyn std::error::Error| {
            complain_of(error);
            Exit::Invalid
        };
        let key = self.key.as_deref().map(read_key).transpose().map_err(|error| refuse(&error))?;
        let address = Address { at: self.bind, key };
        address.check().map_err(|error| refuse(&error))?;
        let audience = self.live.start(&plan, None).map_err(|error| refuse(&error))?;
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
        let batch = Batch::new(plan, options).map_err(|error| refuse(&error))?;
        let interrupter = batch.interrupter();
        // A run that somebody else drives has no end of its own: asked once, it ends.
        let asked = when_asked_to_end(move |_| (0..2).for_each(|_| interrupter.interrupt()));
        let report = batch.run_with_listener(Progress::on_stderr(0, false), &mut NoListener, &|job, wanted, cancel| {
            simulate_with_command_source(job, wanted, cancel, audience.as_deref(), |setup, cancelled| {
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
        tell(audience.as_deref());
        let report = report.map_err(|error| {
            refuse(&error);
            Exit::Unfinished
        })?;
        print(&summary(&report, Shows::default()))?;
        Ok(Exit::of_batch(&report, asked.exit()))
    }
}
