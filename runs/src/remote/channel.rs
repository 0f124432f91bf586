//! Sends and receives the packets of a session over UDP: numbers, authenticates and filters them.

use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};

use crate::remote::counts::Counts;
use crate::remote::impairment::{ImpairedLink, Impairment};
use crate::remote::link_error::LinkError;
use crate::remote::wire::{self, HEADER, Header, Key, Kind, MAX_DATAGRAM, Rejection, TAG_SIZE};

/// Address of a side and the key of its packets.
#[derive(Clone, Debug)]
pub struct Address {
    /// The socket's address.
    pub at: SocketAddr,
    /// Authenticates packets; required unless `at` is on loopback.
    pub key: Option<Key>,
}

impl Address {
    /// Resolves a host.
    pub fn resolve(host: &str, port: u16, key: Option<Key>) -> Result<Self, LinkError> {
        let unknown = |source| LinkError::Name { name: format!("{host}:{port}"), source };
        let mut found = (host, port).to_socket_addrs().map_err(unknown)?;
        let at = found.next().ok_or_else(|| unknown(ErrorKind::NotFound.into()))?;
        let address = Address { at, key };
        address.check().map(|()| address)
    }

    /// Refuses an address beyond loopback without a key.
    pub fn check(&self) -> Result<(), LinkError> {
        if self.at.ip().is_loopback() || self.key.is_some() { Ok(()) } else { Err(LinkError::NoKey(self.at)) }
    }
}

/// Largest number of rejected packets that are read after the end of a wait, about as many as a
/// socket holds. A valid packet behind them is still read, and many rejected ones do not prolong the
/// wait without limit.
const MAX_LATE: usize = 256;

/// UDP socket with the state of a session.
pub(super) struct Channel {
    socket: UdpSocket,
    key: Option<Key>,
    pub session: u64,
    /// Address of the other side; none while waiting for a client.
    pub peer: Option<SocketAddr>,
    sequence: u64,
    /// Sequence numbers of the first and newest accepted packet, and the number of accepted
    /// packets.
    first: u64,
    newest: u64,
    accepted: u64,
    pub counts: Counts,
    sender: Option<ImpairedLink>,
    out: Vec<u8>,
    inbox: Vec<u8>,
    /// Present setting of the socket: `Some(None)` when it does not block.
    timeout: Option<Option<Duration>>,
}

/// A received packet.
pub(super) struct Packet {
    pub header: Header,
    pub from: SocketAddr,
    /// Range of its body in the inbox.
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
            accepted: 0,
            counts: Counts::default(),
            sender: impairment.map(|(impairment, side)| ImpairedLink::new(impairment, side)),
            out: Vec::with_capacity(4096),
            inbox: vec![0; MAX_DATAGRAM],
            timeout: None,
        })
    }

    /// Local address of the socket.
    pub fn local(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// Begins a session with a peer; earlier packets become invalid.
    pub fn begin(&mut self, session: u64, peer: SocketAddr) {
        (self.session, self.peer) = (session, Some(peer));
        (self.first, self.newest, self.accepted) = (0, 0, 0);
    }

    /// Sends a packet to the other side; `body` appends its content and returns its flags.
    pub fn send(
        &mut self,
        kind: Kind,
        time: (u64, f64),
        body: impl FnOnce(&mut Vec<u8>) -> u8,
    ) -> Result<(), LinkError> {
        let Some(peer) = self.peer else { return Ok(()) };
        self.send_to(peer, self.session, kind, time, body)
    }

    /// Sends a packet of a session that has not begun.
    pub fn send_to(
        &mut self,
        to: SocketAddr,
        session: u64,
        kind: Kind,
        (tick, time): (u64, f64),
        body: impl FnOnce(&mut Vec<u8>) -> u8,
    ) -> Result<(), LinkError> {
        self.sequence += 1;
        let header = Header { kind, flags: 0, session, sequence: self.sequence, tick, time };
        wire::begin(&header, &mut self.out);
        let flags = body(&mut self.out);
        self.out[7] |= flags;
        wire::end(self.key.as_ref(), &mut self.out);
        if self.out.len() > MAX_DATAGRAM {
            return Err(LinkError::Long(self.out.len()));
        }
        self.counts.sent += 1;
        let socket = &self.socket;
        // A packet that the system cannot send now counts as lost; the side that waits for an
        // answer resends.
        match &mut self.sender {
            None => drop(socket.send_to(&self.out, to)),
            Some(sender) => sender.send(&self.out, to, |packet, to| drop(socket.send_to(packet, to))),
        }
        Ok(())
    }

    /// Answers a hello of another version with a bye, so that its sender sees the other version.
    fn answer_foreign(&mut self, length: usize, from: SocketAddr) -> Result<(), LinkError> {
        // The answer is not longer than the hello, so it cannot be used to flood a third party.
        let longest = HEADER + TAG_SIZE;
        match wire::foreign_hello(&self.inbox[..length]) {
            Some((session, length)) if self.peer.is_none() && length >= longest => {
                self.send_to(from, session, Kind::Bye, (0, 0.0), |_| 0)
            }
            _ => Ok(()),
        }
    }

    /// Waits for a valid packet until an instant; none if there is none. Rejected packets are
    /// counted.
    ///
    /// In a session, packets must come from the other side, belong to it, and be newer than those
    /// accepted before; only a welcome may belong to another one. Without a session, only hellos and
    /// confirms are valid.
    pub fn receive(&mut self, until: Instant) -> Result<Option<Packet>, LinkError> {
        let mut late = 0;
        loop {
            if let Some(sender) = &mut self.sender {
                let socket = &self.socket;
                sender.flush(|packet, to| drop(socket.send_to(packet, to)));
            }
            let due = self.sender.as_ref().and_then(ImpairedLink::next).map_or(until, |due| due.min(until));
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
                // The other side is not listening yet, or a signal interrupted the call.
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
                Ok(packet) => return Ok(Some(packet)),
                Err(reason) => {
                    self.counts.reject(reason);
                    if reason == Rejection::Version {
                        self.answer_foreign(length, from)?;
                    }
                }
            }
            if Instant::now() >= until {
                late += 1;
                if late > MAX_LATE {
                    return Ok(None);
                }
            }
        }
    }

    /// Receives one datagram; an error of kind `WouldBlock` if there is none in time.
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

    fn accept(&mut self, length: usize, from: SocketAddr) -> Result<Packet, Rejection> {
        let (header, body) = wire::open(&self.inbox[..length], self.key.as_ref())?;
        let start = wire::HEADER;
        let body = start..start + body.len();
        let opens = match self.peer {
            None => matches!(header.kind, Kind::Hello | Kind::Confirm),
            Some(_) => header.kind == Kind::Welcome,
        };
        if !opens {
            if self.peer != Some(from) || header.session != self.session {
                return Err(Rejection::Session);
            }
            if header.sequence <= self.newest {
                return Err(Rejection::Replayed);
            }
        }
        Ok(Packet { header, from, body })
    }

    /// Body of the last received packet.
    pub fn body(&self, packet: &Packet) -> &[u8] {
        &self.inbox[packet.body.clone()]
    }

    /// Marks a packet as accepted; older ones are rejected from now on.
    pub fn mark_accepted(&mut self, packet: &Packet) {
        self.newest = packet.header.sequence;
        if self.accepted == 0 {
            self.first = self.newest;
        }
        self.accepted += 1;
        self.counts.received += 1;
        self.counts.missing = self.newest - self.first + 1 - self.accepted;
    }

    /// Error after a time without packets.
    pub fn silent(&self, after: Duration) -> LinkError {
        let rejected: Vec<_> = Rejection::ALL
            .into_iter()
            .filter(|reason| self.counts.rejected(*reason) > 0)
            .map(|reason| format!("{} dropped ({})", self.counts.rejected(reason), reason.name()))
            .collect();
        let mut found = if rejected.is_empty() { String::new() } else { format!("; {}", rejected.join(", ")) };
        if self.counts.rejected(Rejection::Version) > 0 {
            found += &format!(": both sides need wire format {}", wire::VERSION);
        }
        let address = self.peer.map_or("any client".into(), |peer| peer.to_string());
        LinkError::Silent { address, seconds: after.as_secs_f64(), found }
    }
}
