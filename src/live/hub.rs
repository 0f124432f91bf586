//! Server thread: distributes the queued instants to the connected clients. It polls every few
//! milliseconds, so that the simulation thread makes no system call to wake it.

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::TryRecvError;
use std::thread::park_timeout;
use std::time::{Duration, Instant};

use tungstenite::Message;

use crate::live::client::{Client, ClientEvent, HANDSHAKE_LIMIT};
use crate::live::feed::{Batch, FeedReceiver};
use crate::live::protocol::{self, Request, Subscription};
use crate::live::topic_registry::TopicRegistry;
use crate::live::{Shared, bit, lock};
use crate::log::ChannelInfo;
use crate::web::{AccessError, LocalAccess};

/// Largest number of clients.
const MAX_CLIENTS: usize = 16;
/// Largest number of connections whose handshake is not complete.
const MAX_OPENING: usize = 32;
/// Largest number of connections accepted per round.
const MAX_ACCEPTED: usize = 64;
/// Polling periods: after activity, with clients, without clients.
const POLL: [Duration; 3] = [Duration::from_millis(1), Duration::from_millis(4), Duration::from_millis(20)];
/// Idle rounds before the period grows.
const IDLE_ROUNDS: u32 = 50;
/// Time limits of a flush: without progress, and in total.
const FLUSH_LIMITS: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(5));
/// Largest number of requests handled per client and round.
const MAX_REQUESTS: usize = 64;

/// Called with the reason when a client is refused.
pub(super) type OnRefusal = Box<dyn FnMut(&AccessError) + Send>;

/// State of the server thread.
pub(super) struct Hub {
    listener: TcpListener,
    access: LocalAccess,
    on_refusal: OnRefusal,
    shared: Arc<Shared>,
    session: u64,
    feeds: Vec<FeedReceiver>,
    clients: Vec<Client>,
    /// Registry as announced to the clients, and its version.
    registry: TopicRegistry,
    version: u64,
    /// Time of the last instant, ns.
    time: Option<u64>,
    /// Messages sent to and dropped for clients that have disconnected.
    departed: (u64, u64),
}

impl Hub {
    pub fn new(
        listener: TcpListener,
        (access, on_refusal): (LocalAccess, OnRefusal),
        shared: Arc<Shared>,
        session: u64,
    ) -> Self {
        Hub {
            listener,
            access,
            on_refusal,
            shared,
            session,
            feeds: Vec::new(),
            clients: Vec::new(),
            registry: TopicRegistry::default(),
            version: 0,
            time: None,
            departed: (0, 0),
        }
    }

    pub fn run(mut self) {
        let mut idle = 0;
        while !self.shared.stop.load(Relaxed) {
            let requested = lock(&self.shared.flushes).requested;
            let active = self.round();
            if requested > lock(&self.shared.flushes).done {
                self.flush();
                lock(&self.shared.flushes).done = requested;
                self.shared.flushed.notify_all();
            }
            idle = if active { 0 } else { idle + 1 };
            park_timeout(match self.clients.is_empty() {
                true => POLL[2],
                false if idle > IDLE_ROUNDS => POLL[1],
                false => POLL[0],
            });
        }
        self.shared.subscribed_topics.store(0, Relaxed);
        self.clients.iter_mut().for_each(Client::close);
    }

    /// Accepts, receives, distributes and sends without waiting. Returns whether there was any
    /// activity.
    fn round(&mut self) -> bool {
        let accepted = self.accept();
        self.update_registry();
        let received = self.receive();
        let distributed = self.distribute();
        let mut sent = false;
        for client in &mut self.clients {
            sent |= client.send();
        }
        self.count();
        accepted | received | distributed | sent
    }

    /// Sends all queued messages to clients that still read.
    fn flush(&mut self) {
        let (start, mut progress) = (Instant::now(), Instant::now());
        while self.clients.iter().any(Client::has_queued) && start.elapsed() < FLUSH_LIMITS.1 {
            if self.round() {
                progress = Instant::now();
            } else if progress.elapsed() > FLUSH_LIMITS.0 {
                break;
            }
            park_timeout(POLL[0]);
        }
        self.clients.iter_mut().for_each(Client::drop_backlog);
        self.count();
    }

    /// Accepts connections. Each new one replaces the oldest whose handshake is not complete, if
    /// there are too many of these.
    fn accept(&mut self) -> bool {
        let mut accepted = false;
        for _ in 0..MAX_ACCEPTED {
            let Ok((stream, _)) = self.listener.accept() else { break };
            accepted = true;
            if self.clients.iter().filter(|client| client.is_opening()).count() >= MAX_OPENING
                && let Some(oldest) = self.clients.iter().position(Client::is_opening)
            {
                self.clients.remove(oldest);
            }
            self.clients.extend(Client::new(stream, Instant::now() + HANDSHAKE_LIMIT));
        }
        accepted
    }

    /// Handles the requests of all clients. Returns whether there were any.
    fn receive(&mut self) -> bool {
        let mut received = false;
        for at in 0..self.clients.len() {
            for _ in 0..MAX_REQUESTS {
                let room = self.clients.iter().filter(|client| client.is_open()).count() < MAX_CLIENTS;
                let Some(event) = self.clients[at].receive(&self.access, room) else { break };
                received = true;
                match event {
                    ClientEvent::Refused(reason) => {
                        self.shared.refused.fetch_add(1, Relaxed);
                        (self.on_refusal)(&reason);
                    }
                    ClientEvent::Ignored | ClientEvent::Request(Request::Other) => {}
                    ClientEvent::Opened => self.welcome(at),
                    ClientEvent::Request(Request::Subscribe { subscriptions }) => self.subscribe(at, &subscriptions),
                    ClientEvent::Request(Request::Unsubscribe { subscription_ids }) => {
                        self.clients[at].subscriptions.retain(|s| !subscription_ids.contains(&s.id));
                    }
                }
            }
        }
        self.departed = add_counts(self.departed, self.clients.iter().filter(|client| client.is_closed()));
        self.clients.retain(|client| !client.is_closed());
        if received {
            self.update_subscribed_topics();
        }
        received
    }

    /// Sends a new client the server's description, the topics and the time.
    fn welcome(&mut self, at: usize) {
        self.shared.clients.fetch_add(1, Relaxed);
        let client = &mut self.clients[at];
        client.queue_reliable(Message::text(protocol::server_info(self.session)));
        client.queue_reliable(Message::text(protocol::advertise(open_topics(&self.registry))));
        if let Some(time) = self.time {
            client.queue_reliable(Message::binary(protocol::time(time)));
        }
    }

    fn subscribe(&mut self, at: usize, subscriptions: &[Subscription]) {
        let client = &mut self.clients[at];
        let mut count = 0;
        for subscription in subscriptions {
            let entry = self.registry.channels.get(subscription.channel_id as usize).filter(|entry| entry.is_open);
            let Some(entry) = entry.filter(|_| client.subscribe(*subscription)) else {
                let text = format!("no topic {} to subscribe to, or too many subscriptions", subscription.channel_id);
                client.queue_reliable(Message::text(protocol::status(protocol::WARNING, &text)));
                continue;
            };
            client.queue_retained(subscription.id, entry);
            count += 1;
        }
        if count > 0 {
            // The client now receives every message, so a run that waits for a client may start.
            self.update_subscribed_topics();
            *lock(&self.shared.subscriptions) += count;
            self.shared.subscribed.notify_all();
        }
    }

    /// Publishes which topics have subscribers.
    fn update_subscribed_topics(&self) {
        let all = self.clients.iter().flat_map(|client| &client.subscriptions);
        self.shared.subscribed_topics.store(all.fold(0, |all, s| all | bit(s.channel_id)), Relaxed);
    }

    /// Distributes all queued instants. Returns whether there were any.
    fn distribute(&mut self) -> bool {
        let mut distributed = false;
        self.feeds.append(&mut lock(&self.shared.feeds));
        let mut feeds = std::mem::take(&mut self.feeds);
        feeds.retain(|feed| {
            loop {
                match feed.full.try_recv() {
                    Ok(mut batch) => {
                        distributed = true;
                        self.update_registry();
                        self.distribute_batch(&batch);
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
        distributed
    }

    /// Announces changes of the registry to the clients.
    fn update_registry(&mut self) {
        if self.shared.version.load(Relaxed) == self.version {
            return;
        }
        let new = {
            let registry = lock(&self.shared.registry);
            self.version = self.shared.version.load(Relaxed);
            registry.clone()
        };
        let old = std::mem::replace(&mut self.registry, new);
        let was_open = |at: usize| old.channels.get(at).is_some_and(|entry| entry.is_open);
        let closed = (0..old.channels.len()).filter(|&at| was_open(at) && !self.registry.channels[at].is_open);
        let closed: Vec<u32> = closed.map(|at| at as u32).collect();
        let opened: Vec<_> = open_topics(&self.registry).filter(|(id, _)| !was_open(*id as usize)).collect();
        for client in self.clients.iter_mut().filter(|client| client.is_open()) {
            if !closed.is_empty() {
                client.subscriptions.retain(|s| !closed.contains(&s.channel_id));
                client.queue_reliable(Message::text(protocol::unadvertise(&closed)));
            }
            if !opened.is_empty() {
                client.queue_reliable(Message::text(protocol::advertise(opened.iter().copied())));
            }
            for Subscription { id, channel_id } in client.subscriptions.clone() {
                let at = channel_id as usize;
                if old.channels[at].retained != self.registry.channels[at].retained {
                    client.queue_retained(id, &self.registry.channels[at]);
                }
            }
        }
        self.update_subscribed_topics();
    }

    /// Queues the messages of an instant for their subscribers.
    fn distribute_batch(&mut self, batch: &Batch) {
        let goes_back = self.time.is_some_and(|time| batch.time < time);
        let is_new = self.time.replace(batch.time) != Some(batch.time);
        for client in self.clients.iter_mut().filter(|client| client.is_open()) {
            if goes_back {
                // Viewers discard everything when time goes back, so they need the retained
                // messages again.
                client.promote_backlog();
                client.queue_reliable(Message::binary(protocol::time(batch.time)));
                for Subscription { id, channel_id } in client.subscriptions.clone() {
                    client.queue_retained(id, &self.registry.channels[channel_id as usize]);
                }
            } else if is_new && !client.subscriptions.is_empty() {
                client.queue(Message::binary(protocol::time(batch.time)));
            }
            for (channel, time, bytes) in batch.messages() {
                for at in 0..client.subscriptions.len() {
                    let Subscription { id, channel_id } = client.subscriptions[at];
                    if channel_id == channel {
                        client.queue(Message::binary(protocol::message_data(id, time, bytes)));
                    }
                }
            }
        }
    }

    fn count(&self) {
        let (sent, dropped) = add_counts(self.departed, self.clients.iter());
        self.shared.sent.store(sent, Relaxed);
        self.shared.dropped.store(dropped, Relaxed);
    }
}

/// Open topics, those of the present run, with their numbers.
fn open_topics(registry: &TopicRegistry) -> impl Iterator<Item = (u32, &ChannelInfo)> {
    let entries = registry.channels.iter().enumerate().filter(|(_, entry)| entry.is_open);
    entries.map(|(at, entry)| (at as u32, &*entry.info))
}

/// Messages sent and dropped: `start` plus those of some clients.
fn add_counts<'a>(start: (u64, u64), clients: impl Iterator<Item = &'a Client>) -> (u64, u64) {
    clients.fold(start, |(sent, dropped), client| (sent + client.sent, dropped + client.dropped))
}
