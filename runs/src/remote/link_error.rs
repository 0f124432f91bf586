//! Errors of links and live streams.

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

use thiserror::Error;

use crate::remote::key_file::MAX_KEY_FILE;
use crate::remote::wire::MIN_SECRET;
use crate::sim::{Outcome, RunError};

/// Why a link cannot be opened, or ended.
#[derive(Debug, Error)]
pub enum LinkError {
    /// An address beyond loopback needs authenticated packets.
    #[error("{0} is not a loopback address: such a link needs a key file, the same on both sides")]
    NoKey(SocketAddr),
    /// The host is unknown.
    #[error("cannot resolve {name}: {source}")]
    Name {
        /// Host and port.
        name: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The file of the key cannot be read.
    #[error("cannot read the key in {}: {source}", path.display())]
    KeyFile {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The key is too short to be secret.
    #[error("the key in {} has {length} bytes, expected at least {MIN_SECRET}", path.display())]
    ShortKey {
        /// The file.
        path: PathBuf,
        /// Its length, bytes.
        length: usize,
    },
    /// The file of the key is too long to be one.
    #[error("the key in {} has {length} bytes, expected at most {MAX_KEY_FILE}", path.display())]
    LongKey {
        /// The file.
        path: PathBuf,
        /// Its length, bytes.
        length: u64,
    },
    /// The system has no random numbers.
    #[error("cannot draw random numbers of the system: {0}")]
    Random(String),
    /// A call of the system failed.
    #[error("cannot {what} {address}: {source}")]
    Io {
        /// The operation, such as `bind`.
        what: &'static str,
        /// The address.
        address: SocketAddr,
        /// Error of the system.
        source: io::Error,
    },
    /// No valid packet for [`crate::remote::SILENCE`].
    #[error("no packet from {address} for {seconds} s{found}")]
    Silent {
        /// Address of the other side.
        address: String,
        /// Duration, s.
        seconds: f64,
        /// Text about rejected packets; may be empty.
        found: String,
    },
    /// The other side has a different robot.
    #[error("the robot at {0} has other joints or soles than the one of this scenario")]
    Robot(SocketAddr),
    /// The clocks differ.
    #[error("the robot at {address} is controlled at {there} Hz, this scenario's `control.rate` is {here} Hz")]
    Rate {
        /// Address of the other side.
        address: SocketAddr,
        /// Its rate, Hz.
        there: f64,
        /// Ours, Hz.
        here: f64,
    },
    /// The other side ended the session.
    #[error("{0} has ended the session")]
    Ended(SocketAddr),
    /// Live streams are limited to loopback.
    #[error("{0} is not a loopback address: runs are streamed on loopback only, such as 127.0.0.1:8765")]
    NotLoopback(SocketAddr),
    /// Interrupted by the user.
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
