//! A socket, and what holds for every packet of a session.

use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::remote::counts::Counts;
use crate::remote::error::LinkError;
use crate::remote::impair::{BadLine, Impairment};
use crate::remote::wire::{self, Header, Key, Kind, LONGEST, Refused};

/// Where a side is, and how its packets are sealed.
#[derive(Clone, Debug)]
pub struct Address {
    /// The socket's address.
    pub at: SocketAddr,
    /// Seals packets; needed unless `at` is on loopback.
    pub key: Option<Key>,
}

impl Address {
    /// An address that was written, its key in a file.
    pub fn read(host: &str, port: u16, key: Option<&Path>) -> Result<Self, LinkError> {
        let unknown = |source| LinkError::Name { name: format!("{host}:{port}"), source };
        let mut found = (host, port).to_socket_addrs().map_err(unknown)?;
        let at = found.next().ok_or_else(|| unknown(ErrorKind::NotFound.into()))?;
        let address = Address { at, key: key.map(read_key).transpose()? };
        address.check().map(|()| address)
    }

    /// Refuses to talk in the open beyond this machine.
    pub fn check(&self) -> Result<(), LinkError> {
        if self.at.ip().is_loopback() || self.key.is_some() { Ok(()) } else { Err(LinkError::Unsealed(self.at)) }
    }
}

/// The secret that a file holds, without the line end that an editor puts there.
pub fn read_key(path: &Path) -> Result<Key, LinkError> {
    let secret = std::fs::read(path).map_err(|source| LinkError::KeyFile { path: path.to_owned(), source })?;
    let end = secret.iter().rposition(|byte| !b"\r\n".contains(byte)).map_or(0, |last| last + 1);
    Key::of(&secret[..end]).ok_or_else(|| LinkError::ShortKey { path: path.to_owned(), length: end })
}

/// See the module.
pub(super) struct Channel {
    socket: UdpSocket,
    key: Option<Key>,
    pub session: u64,
    /// The other side.
    pub peer: Option<SocketAddr>,
    sequence: u64,
    /// Numbers of the first and the newest packet of the other side that were acted on, and how many were.
    first: u64,
    newest: u64,
    taken: u64,
    pub counts: Counts,
    line: Option<BadLine>,
    out: Vec<u8>,
    inbox: Vec<u8>,
    /// As the socket is set: none when it does not wait.
    timeout: Option<Option<Duration>>,
}

/// A packet that came.
pub(super) struct Arrived {
    pub header: Header,
    pub from: SocketAddr,
    /// Where in the inbox its body is.
    body: std::ops::Range<usize>,
}

impl Channel {
    /// Binds a socket.
    pub fn bind(address: &Address, impairment: Option<(Impairment, &str)>) -> Result<Self, LinkError> {
        address.check()?;
        let at = address.at;
        let io = |what| move |source| LinkError::Io { what, address: at, source };
        let socket = UdpSocket::bind(at).map_err(io("bind"))?;
        Ok(Channel {
            socket,
            key: address.key.clone(),
            session: 0,
            peer: None,
            sequence: 0,
            first: 0,
            newest: 0,
            taken: 0,
            counts: Counts::default(),
            line: impairment.map(|(how, side)| BadLine::new(how, side)),
            out: Vec::with_capacity(4096),
            inbox: vec![0; LONGEST],
            timeout: None,
        })
    }

    /// The address that the system gave.
    pub fn local(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// Begins a session with a side: what came before counts no more.
    pub fn begin(&mut self, session: u64, peer: SocketAddr) {
        (self.session, self.peer) = (session, Some(peer));
        (self.first, self.newest, self.taken) = (0, 0, 0);
    }

    /// Sends a packet to the other side; `body` appends it and gives its flags.
    pub fn send(
        &mut self,
        kind: Kind,
        (tick, time): (u64, f64),
        body: impl FnOnce(&mut Vec<u8>) -> u8,
    ) -> Result<(), LinkError> {
        let Some(peer) = self.peer else { return Ok(()) };
        self.sequence += 1;
        let header = Header { kind, flags: 0, session: self.session, sequence: self.sequence, tick, time };
        wire::begin(&header, &mut self.out);
        let flags = body(&mut self.out);
        self.out[7] |= flags;
        wire::end(self.key.as_ref(), &mut self.out);
        if self.out.len() > LONGEST {
            return Err(LinkError::Long(self.out.len()));
        }
        self.counts.sent += 1;
        let socket = &self.socket;
        // What the system cannot send now is lost like any other packet; whoever waits for an answer sends it again.
        match &mut self.line {
            None => drop(socket.send_to(&self.out, peer)),
            Some(line) => line.send(&self.out, |packet| drop(socket.send_to(packet, peer))),
        }
        Ok(())
    }

    /// Waits for a packet up to an instant; none when none came. What is refused is counted.
    ///
    /// A hello is let through whatever session it names, everything else only from the other side, in this session, and
    /// newer than what came before.
    pub fn receive(&mut self, until: Instant) -> Result<Option<Arrived>, LinkError> {
        loop {
            if let (Some(line), Some(peer)) = (&mut self.line, self.peer) {
                let socket = &self.socket;
                line.flush(|packet| drop(socket.send_to(packet, peer)));
            }
            let due = self.line.as_ref().and_then(BadLine::next).map_or(until, |due| due.min(until));
            let wait = due.saturating_duration_since(Instant::now());
            let received = self.wait(wait);
            let (length, from) = match received {
                Ok(found) => found,
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    if Instant::now() >= until {
                        return Ok(None);
                    }
                    continue;
                }
                // Nobody listens there yet, or a signal came: as if nothing had come.
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset | ErrorKind::Interrupted
                    ) =>
                {
                    continue;
                }
                Err(source) => {
                    let address = self.peer.or(self.local()).unwrap_or(SocketAddr::from(([0, 0, 0, 0], 0)));
                    return Err(LinkError::Io { what: "receive from", address, source });
                }
            };
            match self.accept(length, from) {
                Ok(arrived) => return Ok(Some(arrived)),
                Err(why) => self.counts.refuse(why),
            }
        }
    }

    /// One datagram, or an error of kind `WouldBlock` when none comes in time.
    fn wait(&mut self, wait: Duration) -> std::io::Result<(usize, SocketAddr)> {
        let blocking = !wait.is_zero();
        let timeout = blocking.then(|| wait.max(Duration::from_micros(50)));
        if self.timeout != Some(timeout) {
            match timeout {
                Some(_) => {
                    self.socket.set_nonblocking(false)?;
                    self.socket.set_read_timeout(timeout)?;
                }
                None => self.socket.set_nonblocking(true)?,
            }
            self.timeout = Some(timeout);
        }
        self.socket.recv_from(&mut self.inbox)
    }

    fn accept(&mut self, length: usize, from: SocketAddr) -> Result<Arrived, Refused> {
        let (header, body) = wire::open(&self.inbox[..length], self.key.as_ref())?;
        let start = wire::HEADER;
        let body = start..start + body.len();
        if header.kind != Kind::Hello && header.kind != Kind::Welcome {
            if self.peer != Some(from) || header.session != self.session {
                return Err(Refused::Session);
            }
            if header.sequence <= self.newest {
                return Err(Refused::Replayed);
            }
        }
        Ok(Arrived { header, from, body })
    }

    /// The body of what came last.
    pub fn body(&self, arrived: &Arrived) -> &[u8] {
        &self.inbox[arrived.body.clone()]
    }

    /// Takes note that a packet was acted on: what is older is acted on no more.
    pub fn take(&mut self, arrived: &Arrived) {
        self.newest = arrived.header.sequence;
        if self.taken == 0 {
            self.first = self.newest;
        }
        self.taken += 1;
        self.counts.received += 1;
        self.counts.missing = self.newest - self.first + 1 - self.taken;
    }

    /// Nothing was heard for a time.
    pub fn silent(&self, after: Duration) -> LinkError {
        let refused: Vec<_> = Refused::ALL
            .into_iter()
            .filter(|why| self.counts.refused(*why) > 0)
            .map(|why| format!("{} dropped ({})", self.counts.refused(why), why.name()))
            .collect();
        let found = if refused.is_empty() { String::new() } else { format!("; {}", refused.join(", ")) };
        let address = self.peer.map_or("anybody".into(), |peer| peer.to_string());
        LinkError::Silent { address, seconds: after.as_secs_f64(), found }
    }
}
