//! Simulation side of the stream: collects the messages of an instant and queues them for the
//! server thread.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::live::topic_registry::TopicRegistry;
use crate::live::{Shared, bit, lock};
use crate::log::{ChannelInfo, MessageSink};

/// Largest number of queued instants. The server polls every few milliseconds, some hundred
/// instants of the smallest robot.
const QUEUE: usize = 512;
/// Number of instants allocated at the start, and bytes of each.
const PREPARED: (usize, usize) = (16, 64 << 10);

/// All messages of an instant, concatenated.
#[derive(Default)]
pub(super) struct Batch {
    /// Time of the instant, ns.
    pub time: u64,
    /// Topic, time and end of each message in `bytes`.
    pub parts: Vec<(u32, u64, usize)>,
    pub bytes: Vec<u8>,
}

impl Batch {
    fn with_capacity(bytes: usize, parts: usize) -> Self {
        Batch { time: 0, parts: Vec::with_capacity(parts), bytes: Vec::with_capacity(bytes) }
    }

    /// Its messages: topic, time, bytes.
    pub fn messages(&self) -> impl Iterator<Item = (u32, u64, &[u8])> {
        let starts = std::iter::once(0).chain(self.parts.iter().map(|part| part.2));
        self.parts.iter().zip(starts).map(|(&(channel, time, end), start)| (channel, time, &self.bytes[start..end]))
    }
}

/// Server side of a feed.
pub(super) struct FeedReceiver {
    pub full: Receiver<Batch>,
    pub empty: SyncSender<Batch>,
}

/// Message sink that queues messages for the server thread.
pub(super) struct Feed {
    shared: Arc<Shared>,
    full: SyncSender<Batch>,
    empty: Receiver<Batch>,
    /// Number of allocated instants.
    allocated: usize,
    current: Option<Batch>,
    /// Largest instant so far: bytes and messages.
    largest: (usize, usize),
    described: bool,
}

impl Feed {
    pub fn new(shared: Arc<Shared>) -> (Self, FeedReceiver) {
        let (full, full_receiver) = sync_channel(QUEUE);
        let (empty_sender, empty) = sync_channel(QUEUE);
        for _ in 0..PREPARED.0 {
            let _ = empty_sender.try_send(Batch::with_capacity(PREPARED.1, 16));
        }
        lock(&shared.registry).begin();
        let feed = Feed {
            shared,
            full,
            empty,
            allocated: PREPARED.0,
            current: None,
            largest: (PREPARED.1, 16),
            described: false,
        };
        (feed, FeedReceiver { full: full_receiver, empty: empty_sender })
    }

    /// Instant being collected; none while the queue is full.
    fn current(&mut self) -> Option<&mut Batch> {
        if self.current.is_none() {
            self.current = match self.empty.try_recv() {
                Ok(batch) => Some(batch),
                Err(_) if self.allocated < QUEUE => {
                    self.allocated += 1;
                    Some(Batch::with_capacity(self.largest.0, self.largest.1))
                }
                Err(_) => None,
            };
        }
        self.current.as_mut()
    }

    /// Changes the registry, and announces the change once the description is complete.
    fn change_registry(&self, change: impl FnOnce(&mut TopicRegistry) -> u32) -> u32 {
        let channel = change(&mut lock(&self.shared.registry));
        if self.described {
            self.publish();
        }
        channel
    }

    /// Announces a change of the registry.
    fn publish(&self) {
        self.shared.version.fetch_add(1, Relaxed);
    }
}

impl MessageSink for Feed {
    fn open_channel(&mut self, channel: &ChannelInfo) -> u32 {
        self.change_registry(|registry| registry.open(channel))
    }

    fn end_description(&mut self) {
        self.described = true;
        self.publish();
    }

    fn has_subscribers(&self) -> bool {
        self.shared.subscribed_topics.load(Relaxed) != 0
    }

    fn is_subscribed(&self, channel: u32) -> bool {
        self.shared.subscribed_topics.load(Relaxed) & bit(channel) != 0
    }

    fn message(&mut self, channel: u32, time: u64, bytes: &[u8]) {
        if !self.described {
            self.change_registry(|registry| {
                registry.retain(channel, time, bytes);
                channel
            });
            return;
        }
        match self.current() {
            Some(batch) => {
                batch.bytes.extend_from_slice(bytes);
                batch.parts.push((channel, time, batch.bytes.len()));
            }
            None => {
                self.shared.missed.fetch_add(1, Relaxed);
            }
        }
    }

    fn end_tick(&mut self, time: u64) {
        let Some(mut batch) = self.current.take_if(|batch| !batch.parts.is_empty()) else { return };
        batch.time = time;
        let (bytes, parts) = self.largest;
        self.largest = (bytes.max(batch.bytes.len()), parts.max(batch.parts.len()));
        if let Err(rejected) = self.full.try_send(batch) {
            // The queue has room for every instant, so the server thread has ended.
            let (std::sync::mpsc::TrySendError::Full(batch) | std::sync::mpsc::TrySendError::Disconnected(batch)) =
                rejected;
            self.shared.missed.fetch_add(batch.parts.len() as u64, Relaxed);
        }
    }
}
