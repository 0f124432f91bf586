//! `--live`: a run that is shown while it is made.

use std::net::SocketAddr;
use std::time::Duration;

use clap::Args;
use stiction::batch::{LiveClients, Plan};

use super::motor_server::address;
use super::numbers::seconds;
use super::terminal::{complain, counted};

/// Options of whoever makes one run.
#[derive(Args, Debug)]
pub struct Live {
    /// Show the run to Foxglove while it is made [default: 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = address)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    live: Option<SocketAddr>,
    /// With --live: wait for somebody who looks on, this long at most
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "live")]
    live_wait: Option<Duration>,
}

impl Live {
    /// Shows the one run of a plan, if it is to be shown, at so many simulated seconds per second.
    pub fn start(&self, plan: &Plan, pace: Option<f64>) -> Result<Option<Box<dyn LiveClients>>, Refused> {
        let Some(address) = self.live else { return Ok(None) };
        if plan.runs() != 1 {
            let runs = counted(plan.runs(), plan.references());
            return Err(Refused(format!(
                "--live shows one run, and this is {runs}: choose one with --filter or --set"
            )));
        }
        self.listen(address, pace).map(Some)
    }

    #[cfg(feature = "live")]
    fn listen(&self, address: SocketAddr, pace: Option<f64>) -> Result<Box<dyn LiveClients>, Refused> {
        let server = stiction::live::Live::start(address).map_err(|error| Refused(error.to_string()))?;
        complain(&format!("live at ws://{}", server.address()));
        Ok(Box::new(Stage { server, pace, patience: self.live_wait, told: std::sync::Mutex::default() }))
    }

    #[cfg(not(feature = "live"))]
    fn listen(&self, _: SocketAddr, _: Option<f64>) -> Result<Box<dyn LiveClients>, Refused> {
        let _ = self.live_wait;
        Err(Refused(
            "this program was built without --live; `cargo build --release --features live` builds it with".into(),
        ))
    }
}

/// Says what there is to say of whoever looked on.
pub fn tell(audience: Option<&dyn LiveClients>) {
    audience.iter().flat_map(|audience| audience.told()).for_each(|line| complain(&line));
}

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Refused(String);

/// Where a run is shown.
#[cfg(feature = "live")]
struct Stage {
    server: stiction::live::Live,
    pace: Option<f64>,
    patience: Option<Duration>,
    told: std::sync::Mutex<Vec<String>>,
}

#[cfg(feature = "live")]
impl LiveClients for Stage {
    fn outlet(&self) -> Box<dyn stiction::log::MessageSink> {
        self.server.outlet()
    }

    fn wait(&self, cancel: &std::sync::atomic::AtomicBool) {
        if let Some(patience) = self.patience
            && !self.server.wait(patience, cancel)
        {
            self.says(format!("nobody came within {} s", patience.as_secs_f64()));
        }
    }

    fn arrivals(&self) -> u64 {
        self.server.subscriptions()
    }

    fn pace(&self) -> Option<f64> {
        self.pace
    }

    fn farewell(&self) {
        self.says(self.server.settle().to_string());
    }

    fn told(&self) -> Vec<String> {
        self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()
    }
}

#[cfg(feature = "live")]
impl Stage {
    fn says(&self, what: String) {
        self.told.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(format!("live: {what}"));
    }
}
