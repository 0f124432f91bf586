//! Options `--live`, `--live-wait` and `--live-origin`: stream a run to viewers while it is simulated.

use std::time::Duration;

use crate::batch::{LiveClients, Plan};
use clap::Args;

use crate::cli::arguments::link::{HostAddress, host_address};
use crate::cli::arguments::numbers::seconds;
use crate::cli::terminal::{complain, counted};

/// Live options of commands that execute one run.
#[derive(Args, Debug)]
pub struct Live {
    /// Stream the run to Foxglove while it is simulated [default: 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = host_address)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    live: Option<HostAddress>,
    /// With --live: wait for a client before the first step, at most this long
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "live")]
    live_wait: Option<Duration>,
    /// With --live: also accept viewers whose page is from this site, such as
    /// https://viewer.example.org; repeatable
    #[arg(long, value_name = "ORIGIN", value_parser = origin, requires = "live")]
    live_origin: Vec<String>,
}

impl Live {
    /// Starts to listen if `--live` is given. `pace` is in simulated seconds per second.
    pub fn start(&self, plan: &Plan, pace: Option<f64>) -> Result<Option<Box<dyn LiveClients>>, LiveError> {
        let Some(address) = &self.live else { return Ok(None) };
        if plan.runs() != 1 {
            let runs = counted(plan.runs(), plan.references());
            return Err(LiveError::SeveralRuns(runs));
        }
        self.listen(address, pace).map(Some)
    }

    fn listen(&self, address: &HostAddress, pace: Option<f64>) -> Result<Box<dyn LiveClients>, LiveError> {
        let access = crate::web::LocalAccess {
            hosts: vec![address.host.clone()],
            origins: self.live_origin.clone(),
            ..crate::web::LocalAccess::default()
        };
        let mut first = true;
        let on_refusal = move |reason: &crate::web::AccessError| {
            if std::mem::take(&mut first) {
                complain(&refusal(reason));
            }
        };
        let server = crate::live::LiveServer::start_with(address.at, access, Box::new(on_refusal))?;
        complain(&format!("live at ws://{}", server.address()));
        Ok(Box::new(Server { server, pace, wait_limit: self.live_wait, notes: std::sync::Mutex::default() }))
    }
}

/// Parses an origin.
fn origin(text: &str) -> Result<String, LiveError> {
    if crate::web::is_origin(text) { Ok(text.to_owned()) } else { Err(LiveError::Origin) }
}

/// Text about a client that is not permitted.
fn refusal(reason: &crate::web::AccessError) -> String {
    use crate::web::AccessError::{Host, Hosts, Origin, Origins};
    let help = match reason {
        Origin(_) => "if it is the site of your viewer, `--live-origin` permits it",
        Host(_) | Hosts(_) => "connect to localhost, or to the address that `--live` was given",
        Origins(_) => "only a defective client sends several",
    };
    format!("live: refused a client: {reason}\nhelp: {help}")
}

/// Prints the notes on live clients.
pub fn print_notes(clients: Option<&dyn LiveClients>) {
    clients.iter().flat_map(|clients| clients.notes()).for_each(|line| complain(&line));
}

/// Why a run cannot be streamed.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The plan has several runs.
    #[error("--live streams one run, and this is {0}: choose one with --filter or --set")]
    SeveralRuns(String),
    /// Not `SCHEME://HOST` or `SCHEME://HOST:PORT`.
    #[error("expected an origin without a path, such as https://viewer.example.org")]
    Origin,
    /// The address cannot be listened on.
    #[error(transparent)]
    Listen(#[from] crate::remote::LinkError),
}

/// Live clients of one run.
struct Server {
    server: crate::live::LiveServer,
    pace: Option<f64>,
    wait_limit: Option<Duration>,
    notes: std::sync::Mutex<Vec<String>>,
}

impl LiveClients for Server {
    fn sink(&self) -> Box<dyn crate::log::MessageSink> {
        self.server.sink()
    }

    fn wait(&self, cancel: &std::sync::atomic::AtomicBool) {
        if let Some(limit) = self.wait_limit
            && !self.server.wait(limit, cancel)
        {
            self.note(format!("no client within {} s", limit.as_secs_f64()));
        }
    }

    fn arrivals(&self) -> u64 {
        self.server.subscriptions()
    }

    fn pace(&self) -> Option<f64> {
        self.pace
    }

    fn finish(&self) {
        self.note(self.server.flush().to_string());
    }

    fn notes(&self) -> Vec<String> {
        self.notes.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()
    }
}

impl Server {
    fn note(&self, text: String) {
        self.notes.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(format!("live: {text}"));
    }
}
