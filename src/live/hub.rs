//! The thread: takes instants from the simulation and connections from the system, and brings them together. It looks around every
//! few milliseconds instead of being woken, so that whoever simulates need not call the system.

use std::net::{Shutdown, TcpListener};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::TryRecvError;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use tungstenite::Message;

use crate::live::book::Book;
use crate::live::client::{Client, Heard};
use crate::live::feed::{Batch, Taken};
use crate::live::protocol::{self, Request, Subscription};
use crate::live::{Shared, bit, lock};
use crate::log::ChannelInfo;
use crate::remote::nonce;

/// Clients at once.
const CLIENTS: usize = 16;
/// How long it looks away: after something happened, when somebody listens, when nobody does.
const LOOK: [Duration; 3] = [Duration::from_millis(1), Duration::from_millis(4), Duration::from_millis(20)];
/// Rounds in which nothing happens before it looks less often.
const SOON: u32 = 50;
/// Clients that take nothing for so long are not waited for at the end of a run; nor is anybody for so long.
const FAREWELL: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(5));
/// What it hears of a client in one round.
const REQUESTS: usize = 64;

/// See the module.
pub(super) struct Hub {
    listener: TcpListener,
    shared: Arc<Shared>,
    session: u64,
    feeds: Vec<Taken>,
    clients: Vec<Client>,
    /// What the clients know.
    book: Book,
    edition: u64,
    /// Of the last instant, ns.
    time: Option<u64>,
    /// What was sent to clients that have left, and what they did not get.
    left: (u64, u64),
}

impl Hub {
    pub fn new(listener: TcpListener, shared: Arc<Shared>) -> Self {
        Hub {
            listener,
            shared,
            session: nonce(),
            feeds: Vec::new(),
            clients: Vec::new(),
            book: Book::default(),
            edition: 0,
            time: None,
            left: (0, 0),
        }
    }

    pub fn run(mut self) {
        let mut idle = 0;
        while !self.shared.ends.load(Relaxed) {
            let asked = lock(&self.shared.settled).asked;
            let moved = self.round();
            if asked > lock(&self.shared.settled).answered {
                self.farewell();
                lock(&self.shared.settled).answered = asked;
                self.shared.quiet.notify_all();
            }
            idle = if moved { 0 } else { idle + 1 };
            let look = match self.clients.is_empty() {
                true => LOOK[2],
                false if idle > SOON => LOOK[1],
                false => LOOK[0],
            };
            park_timeout(look);
        }
        self.shared.wanted.store(0, Relaxed);
        self.clients.iter_mut().for_each(Client::close);
    }

    /// Does what there is to do, without waiting. Was there anything?
    fn round(&mut self) -> bool {
        let came = self.accept();
        self.read_book();
        let asked = self.hear();
        let told = self.pass_on();
        let mut took = false;
        for client in &mut self.clients {
            took |= client.send();
        }
        self.count();
        came | asked | told | took
    }

    /// Sends what was handed over, to all who still take it.
    fn farewell(&mut self) {
        let (start, mut moved) = (Instant::now(), Instant::now());
        while self.clients.iter().any(Client::is_behind) && start.elapsed() < FAREWELL.1 {
            if self.round() {
                moved = Instant::now();
            } else if moved.elapsed() > FAREWELL.0 {
                break;
            }
            park_timeout(LOOK[0]);
        }
        self.clients.iter_mut().for_each(Client::forget);
        self.count();
    }

    fn accept(&mut self) -> bool {
        let mut came = false;
        while let Ok((stream, _)) = self.listener.accept() {
            came = true;
            if self.clients.len() >= CLIENTS {
                let _ = stream.shutdown(Shutdown::Both);
            } else {
                self.clients.extend(Client::new(stream));
            }
        }
        came
    }

    fn hear(&mut self) -> bool {
        let mut heard = false;
        for at in 0..self.clients.len() {
            for _ in 0..REQUESTS {
                let Some(said) = self.clients[at].hear() else { break };
                heard = true;
                match said {
                    Heard::Nothing | Heard::Asked(Request::Other) => {}
                    Heard::Opened => self.welcome(at),
                    Heard::Asked(Request::Subscribe { subscriptions }) => self.subscribe(at, &subscriptions),
                    Heard::Asked(Request::Unsubscribe { subscription_ids }) => {
                        self.clients[at].subscriptions.retain(|s| !subscription_ids.contains(&s.id));
                    }
                }
            }
        }
        self.left = total(self.left, self.clients.iter().filter(|client| client.is_gone()));
        self.clients.retain(|client| !client.is_gone());
        if heard {
            self.want();
        }
        heard
    }

    fn welcome(&mut self, at: usize) {
        self.shared.clients.fetch_add(1, Relaxed);
        let client = &mut self.clients[at];
        client.owe(Message::text(protocol::server_info(self.session)));
        client.owe(Message::text(protocol::advertise(open(&self.book))));
        if let Some(time) = self.time {
            client.owe(Message::binary(protocol::time(time)));
        }
    }

    fn subscribe(&mut self, at: usize, subscriptions: &[Subscription]) {
        let client = &mut self.clients[at];
        let mut count = 0;
        for wanted in subscriptions {
            let entry = self.book.channels.get(wanted.channel_id as usize).filter(|entry| entry.is_open);
            let Some(entry) = entry.filter(|_| client.subscribe(*wanted)) else {
                let words = format!("no topic {} to subscribe to, or too many subscriptions", wanted.channel_id);
                client.owe(Message::text(protocol::status(protocol::WARNING, &words)));
                continue;
            };
            client.owe_kept(wanted.id, entry);
            count += 1;
        }
        if count > 0 {
            // What comes from now on is for it: whoever waits for a client may begin.
            self.want();
            *lock(&self.shared.subscriptions) += count;
            self.shared.subscribed.notify_all();
        }
    }

    /// Says which topics are listened to.
    fn want(&self) {
        let all = self.clients.iter().flat_map(|client| &client.subscriptions);
        self.shared.wanted.store(all.fold(0, |all, s| all | bit(s.channel_id)), Relaxed);
    }

    /// Takes what the simulation handed over and gives it to the clients.
    fn pass_on(&mut self) -> bool {
        let mut told = false;
        self.feeds.append(&mut lock(&self.shared.feeds));
        let mut feeds = std::mem::take(&mut self.feeds);
        feeds.retain(|feed| {
            loop {
                match feed.full.try_recv() {
                    Ok(mut batch) => {
                        told = true;
                        self.read_book();
                        self.give(&batch);
                        batch.bytes.clear();
                        batch.parts.clear();
                        let _ = feed.empty.try_send(batch);
                    }
                    Err(TryRecvError::Empty) => return true,
                    Err(TryRecvError::Disconnected) => return false,
                }
            }
        });
        self.feeds = feeds;
        told
    }

    /// Tells the clients what is new in the book.
    fn read_book(&mut self) {
        if self.shared.edition.load(Relaxed) == self.edition {
            return;
        }
        let new = {
            let book = lock(&self.shared.book);
            self.edition = self.shared.edition.load(Relaxed);
            book.clone()
        };
        let old = std::mem::replace(&mut self.book, new);
        let was_open = |at: usize| old.channels.get(at).is_some_and(|entry| entry.is_open);
        let closed = (0..old.channels.len()).filter(|&at| was_open(at) && !self.book.channels[at].is_open);
        let closed: Vec<u32> = closed.map(|at| at as u32).collect();
        let opened: Vec<_> = open(&self.book).filter(|(id, _)| !was_open(*id as usize)).collect();
        for client in self.clients.iter_mut().filter(|client| client.is_open()) {
            if !closed.is_empty() {
                client.subscriptions.retain(|s| !closed.contains(&s.channel_id));
                client.owe(Message::text(protocol::unadvertise(&closed)));
            }
            if !opened.is_empty() {
                client.owe(Message::text(protocol::advertise(opened.iter().copied())));
            }
            for Subscription { id, channel_id } in client.subscriptions.clone() {
                let at = channel_id as usize;
                if old.channels[at].kept != self.book.channels[at].kept {
                    client.owe_kept(id, &self.book.channels[at]);
                }
            }
        }
        self.want();
    }

    fn give(&mut self, batch: &Batch) {
        let is_back = self.time.is_some_and(|time| batch.time < time);
        let is_new = self.time.replace(batch.time) != Some(batch.time);
        for client in self.clients.iter_mut().filter(|client| client.is_open()) {
            if is_back {
                // Viewers forget all there was when time goes back.
                client.owe_backlog();
                client.owe(Message::binary(protocol::time(batch.time)));
                for Subscription { id, channel_id } in client.subscriptions.clone() {
                    client.owe_kept(id, &self.book.channels[channel_id as usize]);
                }
            } else if is_new && !client.subscriptions.is_empty() {
                client.offer(Message::binary(protocol::time(batch.time)));
            }
            for (channel, time, bytes) in batch.messages() {
                for at in 0..client.subscriptions.len() {
                    let Subscription { id, channel_id } = client.subscriptions[at];
                    if channel_id == channel {
                        client.offer(Message::binary(protocol::message_data(id, time, bytes)));
                    }
                }
            }
        }
    }

    fn count(&self) {
        let (sent, dropped) = total(self.left, self.clients.iter());
        self.shared.sent.store(sent, Relaxed);
        self.shared.dropped.store(dropped, Relaxed);
    }
}

/// Topics of the present run.
fn open(book: &Book) -> impl Iterator<Item = (u32, &ChannelInfo)> {
    let entries = book.channels.iter().enumerate().filter(|(_, entry)| entry.is_open);
    entries.map(|(at, entry)| (at as u32, &*entry.info))
}

/// Messages sent and dropped, these and those of some clients.
fn total<'a>(left: (u64, u64), clients: impl Iterator<Item = &'a Client>) -> (u64, u64) {
    clients.fold(left, |(sent, dropped), client| (sent + client.sent, dropped + client.dropped))
}
