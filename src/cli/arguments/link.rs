//! Parses addresses and paces of links.

use std::net::{SocketAddr, ToSocketAddrs};

use crate::remote::Pace;

/// Why an argument of a link is invalid.
#[derive(Debug, thiserror::Error)]
pub enum LinkArgumentError {
    /// Not `HOST:PORT`.
    #[error("expected an address with a port, such as 127.0.0.1:4747")]
    Address,
    /// The host has no address.
    #[error("host not found: {0}\nhelp: check the name, or give the address, such as 127.0.0.1:4747")]
    Host(String),
    /// Not a pace.
    #[error("expected `free`, `realtime` or a number greater than 0")]
    Pace,
}

/// An address and the host that the user gave.
#[derive(Clone, Debug)]
pub struct HostAddress {
    /// The host as given, without port.
    pub host: String,
    /// Its first address.
    pub at: SocketAddr,
}

/// Resolves a host with a port.
pub fn host_address(text: &str) -> Result<HostAddress, LinkArgumentError> {
    let host = text.rsplit_once(':').filter(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    let (host, _) = host.ok_or(LinkArgumentError::Address)?;
    let found = text.to_socket_addrs().ok().and_then(|mut found| found.next());
    let at = found.ok_or_else(|| LinkArgumentError::Host(host.to_owned()))?;
    Ok(HostAddress { host: host.to_owned(), at })
}

/// Like [`host_address`], without the host.
pub fn address(text: &str) -> Result<SocketAddr, LinkArgumentError> {
    host_address(text).map(|found| found.at)
}

/// Parses the pace of a clock.
pub fn pace(text: &str) -> Result<Pace, LinkArgumentError> {
    match text {
        "free" => Ok(Pace::Free),
        "realtime" => Ok(Pace::Times(1.0)),
        number => {
            let times = number.parse().ok().filter(|times: &f64| times.is_finite() && *times > 0.0);
            times.map(Pace::Times).ok_or(LinkArgumentError::Pace)
        }
    }
}
