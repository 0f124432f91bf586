//! The simulation's side: collects an instant's messages and hands them over.

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use crate::live::book::Book;
use crate::live::{Shared, bit, lock};
use crate::log::{ChannelInfo, MessageSink};

/// Instants under way at most. The thread looks every few milliseconds, which are some hundred instants of the smallest robot.
const QUEUE: usize = 512;
/// Instants there is memory for from the start, and how much.
const PREPARED: (usize, usize) = (16, 64 << 10);

/// All messages of an instant, one after the other.
#[derive(Default)]
pub(super) struct Batch {
    /// Of the instant, ns.
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

/// The thread's end of a feed.
pub(super) struct Taken {
    pub full: Receiver<Batch>,
    pub empty: SyncSender<Batch>,
}

/// See the module.
pub(super) struct Feed {
    shared: Arc<Shared>,
    full: SyncSender<Batch>,
    empty: Receiver<Batch>,
    /// Instants that there is memory for.
    made: usize,
    now: Option<Batch>,
    /// The greatest so far: bytes and messages.
    greatest: (usize, usize),
    described: bool,
}

impl Feed {
    pub fn new(shared: Arc<Shared>) -> (Self, Taken) {
        let (full, take) = sync_channel(QUEUE);
        let (back, empty) = sync_channel(QUEUE);
        for _ in 0..PREPARED.0 {
            let _ = back.try_send(Batch::with_capacity(PREPARED.1, 16));
        }
        lock(&shared.book).begin();
        let feed =
            Feed { shared, full, empty, made: PREPARED.0, now: None, greatest: (PREPARED.1, 16), described: false };
        (feed, Taken { full: take, empty: back })
    }

    /// The instant that is collected. None: as many are under way as may be.
    fn now(&mut self) -> Option<&mut Batch> {
        if self.now.is_none() {
            self.now = match self.empty.try_recv() {
                Ok(batch) => Some(batch),
                Err(_) if self.made < QUEUE => {
                    self.made += 1;
                    Some(Batch::with_capacity(self.greatest.0, self.greatest.1))
                }
                Err(_) => None,
            };
        }
        self.now.as_mut()
    }

    fn write(&self, change: impl FnOnce(&mut Book) -> u32) -> u32 {
        let changed = change(&mut lock(&self.shared.book));
        if self.described {
            self.publish();
        }
        changed
    }

    /// A description is read once it is whole.
    fn publish(&self) {
        self.shared.edition.fetch_add(1, Relaxed);
    }
}

impl MessageSink for Feed {
    fn open_channel(&mut self, channel: &ChannelInfo) -> u32 {
        self.write(|book| book.open(channel))
    }

    fn end_description(&mut self) {
        self.described = true;
        self.publish();
    }

    fn has_subscribers(&self) -> bool {
        self.shared.wanted.load(Relaxed) != 0
    }

    fn is_subscribed(&self, channel: u32) -> bool {
        self.shared.wanted.load(Relaxed) & bit(channel) != 0
    }

    fn message(&mut self, channel: u32, time: u64, bytes: &[u8]) {
        if !self.described {
            self.write(|book| {
                book.keep(channel, time, bytes);
                channel
            });
            return;
        }
        match self.now() {
            Some(now) => {
                now.bytes.extend_from_slice(bytes);
                now.parts.push((channel, time, now.bytes.len()));
            }
            None => {
                self.shared.missed.fetch_add(1, Relaxed);
            }
        }
    }

    fn end_tick(&mut self, time: u64) {
        let Some(mut now) = self.now.take_if(|now| !now.parts.is_empty()) else { return };
        now.time = time;
        let (bytes, parts) = self.greatest;
        self.greatest = (bytes.max(now.bytes.len()), parts.max(now.parts.len()));
        if let Err(refused) = self.full.try_send(now) {
            // There is room for all there are, so the thread has ended.
            let (std::sync::mpsc::TrySendError::Full(batch) | std::sync::mpsc::TrySendError::Disconnected(batch)) =
                refused;
            self.shared.missed.fetch_add(batch.parts.len() as u64, Relaxed);
        }
    }
}
