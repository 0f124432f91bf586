//! One client: from its first byte to its last.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use crate::live::book::Entry;
use crate::live::handshake::{self, Answer};
use crate::live::protocol::{self, Request, Subscription};

/// What a client may be behind, bytes: a second or so of a humanoid's log at real time is a megabyte.
const BACKLOG: usize = 16 << 20;
/// What it may leave unread of what is not dropped, bytes: descriptions it asked for again and again.
const OWED: usize = 128 << 20;
/// A request is not longer, bytes.
const REQUEST: usize = 1 << 20;
/// Subscriptions it may have.
const SUBSCRIPTIONS: usize = 1024;
/// How long a handshake may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// See the module.
pub(super) struct Client {
    line: Line,
    pub subscriptions: Vec<Subscription>,
    /// Never dropped: who the server is, topics, what holds for the whole run.
    first: VecDeque<Message>,
    owed: usize,
    /// What is dropped when there is too much of it, the oldest first.
    backlog: VecDeque<Message>,
    behind: usize,
    /// Did the socket take less than it was given?
    blocked: bool,
    warned: bool,
    /// Messages of topics: sent, and dropped.
    pub sent: u64,
    pub dropped: u64,
}

enum Line {
    Opening { stream: TcpStream, came: Vec<u8>, since: Instant },
    Open(Box<WebSocket<TcpStream>>),
    Gone,
}

/// What came of looking at a client.
pub(super) enum Heard {
    /// Nothing that concerns others.
    Nothing,
    /// It is connected, and must be told of what there is.
    Opened,
    /// It wants something.
    Asked(Request),
}

impl Client {
    /// A connection that was accepted.
    pub fn new(stream: TcpStream) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Client {
            line: Line::Opening { stream, came: Vec::new(), since: Instant::now() },
            subscriptions: Vec::new(),
            first: VecDeque::new(),
            owed: 0,
            backlog: VecDeque::new(),
            behind: 0,
            blocked: false,
            warned: false,
            sent: 0,
            dropped: 0,
        })
    }

    pub fn is_open(&self) -> bool {
        matches!(self.line, Line::Open(_))
    }

    pub fn is_gone(&self) -> bool {
        matches!(self.line, Line::Gone)
    }

    /// Is there something to send?
    pub fn is_behind(&self) -> bool {
        self.is_open() && (self.blocked || !self.first.is_empty() || !self.backlog.is_empty())
    }

    /// Messages of topics that wait.
    pub fn waiting(&self) -> u64 {
        self.backlog.iter().filter(|message| is_counted(message)).count() as u64
    }

    /// Looks whether it said something; none when there is nothing more.
    pub fn hear(&mut self) -> Option<Heard> {
        match &mut self.line {
            Line::Gone => None,
            Line::Opening { .. } => self.open(),
            Line::Open(socket) => match socket.read() {
                Ok(Message::Text(text)) => {
                    let request = serde_json::from_str(&text);
                    if request.is_err() {
                        self.owe(Message::text(protocol::status(protocol::WARNING, "this is no request")));
                    }
                    Some(request.map_or(Heard::Nothing, Heard::Asked))
                }
                // What clients publish, and pings, which are answered.
                Ok(_) => Some(Heard::Nothing),
                Err(error) => {
                    self.fail(&error);
                    None
                }
            },
        }
    }

    fn open(&mut self) -> Option<Heard> {
        let Line::Opening { stream, came, since } = &mut self.line else { return None };
        let mut piece = [0; 4096];
        match stream.read(&mut piece) {
            Ok(0) => self.line = Line::Gone,
            Ok(length) => {
                came.extend_from_slice(&piece[..length]);
                match handshake::answer(came) {
                    Answer::Wait => return Some(Heard::Nothing),
                    Answer::Refuse(response) => {
                        // It is short, and the first that is sent.
                        let _ = stream.write_all(response.as_bytes());
                        self.line = Line::Gone;
                    }
                    Answer::Accept(response, length) => {
                        let rest = came.split_off(length);
                        let written = stream.write_all(response.as_bytes());
                        let Line::Opening { stream, .. } = std::mem::replace(&mut self.line, Line::Gone) else {
                            return None;
                        };
                        if written.is_ok() {
                            let config = WebSocketConfig::default()
                                .max_message_size(Some(REQUEST))
                                .max_frame_size(Some(REQUEST));
                            let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
                            self.line = Line::Open(Box::new(socket));
                            return Some(Heard::Opened);
                        }
                    }
                }
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock && since.elapsed() < PATIENCE => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => self.line = Line::Gone,
        }
        None
    }

    /// Subscribes; false when it has too many.
    pub fn subscribe(&mut self, wanted: Subscription) -> bool {
        self.subscriptions.retain(|s| s.id != wanted.id);
        let fits = self.subscriptions.len() < SUBSCRIPTIONS;
        if fits {
            self.subscriptions.push(wanted);
        }
        fits
    }

    /// Will send this whatever happens.
    pub fn owe(&mut self, message: Message) {
        self.owed += message.len();
        self.first.push_back(message);
        if self.owed > OWED {
            self.line = Line::Gone;
        }
    }

    /// Will send what holds for the whole run.
    pub fn owe_kept(&mut self, subscription: u32, entry: &Entry) {
        for (time, bytes) in entry.kept.iter() {
            self.owe(Message::binary(protocol::message_data(subscription, *time, bytes)));
        }
    }

    /// Will send all that waits before what is owed from now on.
    pub fn owe_backlog(&mut self) {
        while let Some(message) = next(&mut self.backlog, &mut self.behind) {
            self.owe(message);
        }
    }

    /// Will send this unless too much of it waits.
    pub fn offer(&mut self, message: Message) {
        self.behind += message.len();
        self.backlog.push_back(message);
        while self.behind > BACKLOG
            && let Some(oldest) = next(&mut self.backlog, &mut self.behind)
        {
            self.dropped += u64::from(is_counted(&oldest));
            if !std::mem::replace(&mut self.warned, true) {
                // Lichtblick knows these words, and says what to do.
                self.owe(Message::text(protocol::status(protocol::WARNING, "Send buffer limit reached")));
            }
        }
    }

    /// Gives the socket as much as it takes. Did it take anything?
    pub fn send(&mut self) -> bool {
        let mut took = false;
        loop {
            let Line::Open(socket) = &mut self.line else { return took };
            let message = match self.blocked {
                true => None,
                false => next(&mut self.first, &mut self.owed).or_else(|| next(&mut self.backlog, &mut self.behind)),
            };
            let result = match message {
                Some(message) => {
                    self.sent += u64::from(is_counted(&message));
                    took = true;
                    socket.write(message)
                }
                None => {
                    let flushed = socket.flush();
                    took |= self.blocked && flushed.is_ok();
                    self.blocked &= flushed.is_err();
                    match flushed {
                        Ok(()) if self.first.is_empty() && self.backlog.is_empty() => return took,
                        flushed => flushed,
                    }
                }
            };
            if let Err(error) = result {
                self.fail(&error);
                self.blocked = true;
                return took;
            }
        }
    }

    /// Drops what waits; how much that was is counted.
    pub fn forget(&mut self) {
        self.dropped += self.waiting();
        self.backlog.clear();
        self.behind = 0;
    }

    /// Takes leave, if it listens.
    pub fn close(&mut self) {
        if let Line::Open(socket) = &mut self.line {
            let (code, reason) = (CloseCode::Away, "the run is over".into());
            let _ = socket.close(Some(CloseFrame { code, reason }));
            let _ = socket.flush();
        }
        self.line = Line::Gone;
    }

    fn fail(&mut self, error: &Error) {
        let waits = matches!(error, Error::Io(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted));
        if !waits {
            self.line = Line::Gone;
        }
    }
}

/// Takes the oldest of a queue of so many bytes.
fn next(queue: &mut VecDeque<Message>, bytes: &mut usize) -> Option<Message> {
    let message = queue.pop_front()?;
    *bytes -= message.len();
    Some(message)
}

/// Is it a message of a topic?
fn is_counted(message: &Message) -> bool {
    matches!(message, Message::Binary(bytes) if protocol::is_message(bytes))
}
