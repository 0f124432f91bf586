//! Connection of one client: handshake, requests, bounded queues.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use crate::live::handshake::{self, HandshakeResult, parse_handshake};
use crate::live::protocol::{self, Request, Subscription};
use crate::live::topic_registry::TopicEntry;
use crate::web::{AccessError, LocalAccess};

/// Largest backlog of messages that may be dropped, bytes. A second of a humanoid's log is about a
/// megabyte.
const MAX_BACKLOG: usize = 16 << 20;
/// Largest queue of messages that are never dropped, bytes. It grows if a client keeps requesting
/// descriptions.
const MAX_RELIABLE: usize = 128 << 20;
/// Largest length of a request, bytes.
const MAX_REQUEST: usize = 1 << 20;
/// Largest number of subscriptions.
const MAX_SUBSCRIPTIONS: usize = 1024;
/// Time limit of a handshake, from the start of the connection.
pub(super) const HANDSHAKE_LIMIT: Duration = Duration::from_secs(5);

/// A connected client with its subscriptions and queues.
pub(super) struct Client {
    connection: Connection,
    pub subscriptions: Vec<Subscription>,
    /// Messages that are never dropped: server, topics, retained messages.
    reliable: VecDeque<Message>,
    reliable_bytes: usize,
    /// Messages of which the oldest are dropped when there are too many.
    backlog: VecDeque<Message>,
    backlog_bytes: usize,
    /// True if the socket has accepted a message only in part.
    blocked: bool,
    warned: bool,
    /// Messages of topics: sent, and dropped.
    pub sent: u64,
    pub dropped: u64,
}

enum Connection {
    Opening { stream: TcpStream, received: Vec<u8>, deadline: Instant },
    Open(Box<WebSocket<TcpStream>>),
    Closed,
}

/// Result of reading from a client.
pub(super) enum ClientEvent {
    /// Nothing to handle.
    Ignored,
    /// The handshake is complete; it needs the list of topics.
    Opened,
    /// The client is not permitted; the connection is closed.
    Refused(AccessError),
    /// A request.
    Request(Request),
}

impl Client {
    /// Wraps an accepted connection, whose handshake must be complete by `deadline`.
    pub fn new(stream: TcpStream, deadline: Instant) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Client {
            connection: Connection::Opening { stream, received: Vec::new(), deadline },
            subscriptions: Vec::new(),
            reliable: VecDeque::new(),
            reliable_bytes: 0,
            backlog: VecDeque::new(),
            backlog_bytes: 0,
            blocked: false,
            warned: false,
            sent: 0,
            dropped: 0,
        })
    }

    pub fn is_open(&self) -> bool {
        matches!(self.connection, Connection::Open(_))
    }

    /// True during the handshake.
    pub fn is_opening(&self) -> bool {
        matches!(self.connection, Connection::Opening { .. })
    }

    pub fn is_closed(&self) -> bool {
        matches!(self.connection, Connection::Closed)
    }

    /// True if there is data to send.
    pub fn has_queued(&self) -> bool {
        self.is_open() && (self.blocked || !self.reliable.is_empty() || !self.backlog.is_empty())
    }

    /// Number of queued topic messages.
    pub fn waiting(&self) -> u64 {
        self.backlog.iter().filter(|message| is_counted(message)).count() as u64
    }

    /// Reads the next event; none if there is no more data. Without `room` for another client, a
    /// complete handshake is refused.
    pub fn receive(&mut self, access: &LocalAccess, room: bool) -> Option<ClientEvent> {
        match &mut self.connection {
            Connection::Closed => None,
            Connection::Opening { .. } => self.continue_handshake(access, room),
            Connection::Open(socket) => match socket.read() {
                Ok(Message::Text(text)) => {
                    let request = protocol::parse_request(&text);
                    if request.is_none() {
                        self.queue_reliable(Message::text(protocol::status(protocol::WARNING, "invalid request")));
                    }
                    Some(request.map_or(ClientEvent::Ignored, ClientEvent::Request))
                }
                // Published messages are ignored; the library answers pings.
                Ok(_) => Some(ClientEvent::Ignored),
                Err(error) => {
                    self.fail(&error);
                    None
                }
            },
        }
    }

    fn continue_handshake(&mut self, access: &LocalAccess, room: bool) -> Option<ClientEvent> {
        let Connection::Opening { stream, received, deadline } = &mut self.connection else { return None };
        let mut buffer = [0; 4096];
        let length = match stream.read(&mut buffer) {
            _ if Instant::now() >= *deadline => 0,
            Ok(length) => length,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => return None,
            Err(_) => 0,
        };
        if length == 0 {
            self.connection = Connection::Closed;
            return None;
        }
        received.extend_from_slice(&buffer[..length]);
        let (response, length) = match parse_handshake(received, access) {
            HandshakeResult::Incomplete => return Some(ClientEvent::Ignored),
            HandshakeResult::Accept(response, length) if room => (response, length),
            other => {
                let (response, reason) = match other {
                    HandshakeResult::Refuse(response, reason) => (response, reason),
                    _ => (handshake::response("503 Service Unavailable", "as many clients as possible"), None),
                };
                // The response is short and the first data sent, so one write suffices.
                let _ = stream.write_all(response.as_bytes());
                self.connection = Connection::Closed;
                return reason.map(ClientEvent::Refused);
            }
        };
        let rest = received.split_off(length);
        let written = stream.write_all(response.as_bytes());
        let Connection::Opening { stream, .. } = std::mem::replace(&mut self.connection, Connection::Closed) else {
            return None;
        };
        written.ok()?;
        let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(socket_config()));
        self.connection = Connection::Open(Box::new(socket));
        Some(ClientEvent::Opened)
    }

    /// Adds a subscription; false if there are too many.
    pub fn subscribe(&mut self, subscription: Subscription) -> bool {
        self.subscriptions.retain(|s| s.id != subscription.id);
        let fits = self.subscriptions.len() < MAX_SUBSCRIPTIONS;
        if fits {
            self.subscriptions.push(subscription);
        }
        fits
    }

    /// Queues a message that is never dropped.
    pub fn queue_reliable(&mut self, message: Message) {
        self.reliable_bytes += message.len();
        self.reliable.push_back(message);
        if self.reliable_bytes > MAX_RELIABLE {
            self.connection = Connection::Closed;
        }
    }

    /// Queues the retained messages of a topic.
    pub fn queue_retained(&mut self, subscription: u32, entry: &TopicEntry) {
        for (time, bytes) in entry.retained.iter() {
            self.queue_reliable(Message::binary(protocol::message_data(subscription, *time, bytes)));
        }
    }

    /// Moves the backlog to the queue that is never dropped, so that it is sent before later
    /// messages of that queue.
    pub fn promote_backlog(&mut self) {
        while let Some(message) = next(&mut self.backlog, &mut self.backlog_bytes) {
            self.queue_reliable(message);
        }
    }

    /// Queues a message that may be dropped.
    pub fn queue(&mut self, message: Message) {
        self.backlog_bytes += message.len();
        self.backlog.push_back(message);
        while self.backlog_bytes > MAX_BACKLOG
            && let Some(oldest) = next(&mut self.backlog, &mut self.backlog_bytes)
        {
            self.dropped += u64::from(is_counted(&oldest));
            if !std::mem::replace(&mut self.warned, true) {
                // Lichtblick recognizes this text and shows advice.
                self.queue_reliable(Message::text(protocol::status(protocol::WARNING, "Send buffer limit reached")));
            }
        }
    }

    /// Writes as much as the socket accepts. Returns whether it accepted anything.
    pub fn send(&mut self) -> bool {
        let mut progress = false;
        loop {
            let Connection::Open(socket) = &mut self.connection else { return progress };
            let message = match self.blocked {
                true => None,
                false => next(&mut self.reliable, &mut self.reliable_bytes)
                    .or_else(|| next(&mut self.backlog, &mut self.backlog_bytes)),
            };
            let result = match message {
                Some(message) => {
                    self.sent += u64::from(is_counted(&message));
                    progress = true;
                    socket.write(message)
                }
                None => {
                    let flushed = socket.flush();
                    progress |= self.blocked && flushed.is_ok();
                    self.blocked &= flushed.is_err();
                    match flushed {
                        Ok(()) if self.reliable.is_empty() && self.backlog.is_empty() => return progress,
                        flushed => flushed,
                    }
                }
            };
            if let Err(error) = result {
                self.fail(&error);
                self.blocked = true;
                return progress;
            }
        }
    }

    /// Drops the backlog and counts its messages.
    pub fn drop_backlog(&mut self) {
        self.dropped += self.waiting();
        self.backlog.clear();
        self.backlog_bytes = 0;
    }

    /// Closes the connection with a close frame.
    pub fn close(&mut self) {
        if let Connection::Open(socket) = &mut self.connection {
            let (code, reason) = (CloseCode::Away, "the run has ended".into());
            let _ = socket.close(Some(CloseFrame { code, reason }));
            let _ = socket.flush();
        }
        self.connection = Connection::Closed;
    }

    fn fail(&mut self, error: &Error) {
        let retry = matches!(error, Error::Io(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted));
        if !retry {
            self.connection = Connection::Closed;
        }
    }
}

/// Removes the oldest message of a queue and subtracts its length from `bytes`.
fn next(queue: &mut VecDeque<Message>, bytes: &mut usize) -> Option<Message> {
    let message = queue.pop_front()?;
    *bytes -= message.len();
    Some(message)
}

/// True for a topic message.
fn is_counted(message: &Message) -> bool {
    matches!(message, Message::Binary(bytes) if protocol::is_message(bytes))
}

/// Limits on the frames of a client.
pub(super) fn socket_config() -> WebSocketConfig {
    WebSocketConfig::default().max_message_size(Some(MAX_REQUEST)).max_frame_size(Some(MAX_REQUEST))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn a_handshake_ends_at_its_deadline_although_bytes_arrive() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut peer = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let mut client = Client::new(listener.accept().unwrap().0, Instant::now()).unwrap();
        peer.write_all(b"GET / HTTP/1.1\r\n").unwrap();
        assert!(client.receive(&LocalAccess::default(), true).is_none());
        assert!(client.is_closed());
    }
}
