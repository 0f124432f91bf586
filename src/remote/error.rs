//! What can go wrong between two sides.

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

use thiserror::Error;

use crate::remote::wire::SHORTEST_SECRET;
use crate::sim::{Outcome, RunError};

/// Why a link does not come about or ends.
#[derive(Debug, Error)]
pub enum LinkError {
    /// Beyond this machine packets must be sealed.
    #[error("{0} is not on this machine's loopback: a key file is needed there, which both sides have")]
    Unsealed(SocketAddr),
    /// Nobody knows the host.
    #[error("cannot find {name}: {source}")]
    Name {
        /// Host and port.
        name: String,
        /// Why not.
        source: io::Error,
    },
    /// The file of the key cannot be read.
    #[error("cannot read the key in {}: {source}", path.display())]
    KeyFile {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The key is no secret.
    #[error("the key in {} has {length} bytes; at least {SHORTEST_SECRET} are wanted", path.display())]
    ShortKey {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        length: usize,
    },
    /// The system refuses.
    #[error("cannot {what} {address}: {source}")]
    Io {
        /// What was tried.
        what: &'static str,
        /// The address it is about.
        address: SocketAddr,
        /// Why not.
        source: io::Error,
    },
    /// Nothing was heard for [`crate::remote::SILENCE`].
    #[error("nothing was heard from {address} for {seconds} s{found}")]
    Silent {
        /// Of the other side.
        address: String,
        /// How long.
        seconds: f64,
        /// Packets that came and were refused, in words.
        found: String,
    },
    /// The other side has another robot.
    #[error("the robot at {0} has other joints or soles than the one of this scenario")]
    Robot(SocketAddr),
    /// The clocks differ.
    #[error("the robot at {address} is controlled at {there} Hz, this scenario's `control.rate` is {here} Hz")]
    Rate {
        /// Of the other side.
        address: SocketAddr,
        /// Its rate, Hz.
        there: f64,
        /// Ours, Hz.
        here: f64,
    },
    /// The other side ended the session.
    #[error("{0} has ended the session")]
    Ended(SocketAddr),
    /// What is shown is shown to this machine only.
    #[error("{0} is not on this machine's loopback: a run is shown there only, such as at 127.0.0.1:8765")]
    NotLoopback(SocketAddr),
    /// Ended from outside.
    #[error("interrupted")]
    Cancelled,
    /// A packet would be longer than a datagram can be.
    #[error("{0} bytes are more than a datagram holds (65507)")]
    Long(usize),
}

impl From<LinkError> for RunError {
    fn from(error: LinkError) -> Self {
        let outcome = if matches!(error, LinkError::Cancelled) { Outcome::Cancelled } else { Outcome::Error };
        RunError::new(outcome, error.to_string())
    }
}
