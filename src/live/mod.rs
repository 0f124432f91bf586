//! What a log would hold, while it is made: topics over a WebSocket on this machine's loopback, in Foxglove's protocol.
//!
//! ```text
//! simulation -> Feed -> bounded queue -> thread (hub) -> a bounded backlog per client -> sockets that never block
//!                 ^--- empty instants <---'
//! ```
//!
//! The thread that simulates hands over what it has encoded, an instant of the log at a time, and takes back the memory of old
//! ones; it makes no system call, waits for nobody, and does not even encode what nobody listens to. When the queue is full an
//! instant is left out, when a client reads too slowly its oldest messages are; both are counted.

mod book;
mod client;
mod feed;
mod handshake;
mod hub;
mod protocol;

use std::fmt;
use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::log::MessageSink;
use crate::remote::LinkError;
use book::Book;
use feed::{Feed, Taken};
use hub::Hub;

/// How long whoever waits for a client looks away from being cancelled.
const SLICE: Duration = Duration::from_millis(50);

/// A server on loopback, with a thread of its own. Dropped, it takes leave of its clients.
pub struct Live {
    shared: Arc<Shared>,
    at: SocketAddr,
    thread: Option<JoinHandle<()>>,
}

/// What was sent so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// Clients that came.
    pub clients: u64,
    /// Messages that went to them, each counted once for each client.
    pub sent: u64,
    /// Messages that a client did not get because it read too slowly.
    pub dropped: u64,
    /// Messages that no client got because the server itself was too slow.
    pub missed: u64,
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Told { clients, sent, dropped, missed } = self;
        let word = if *clients == 1 { "client" } else { "clients" };
        write!(
            f,
            "{clients} {word}, {sent} messages sent, {dropped} dropped for slow readers, {missed} not taken in time"
        )
    }
}

/// What both threads see.
#[derive(Default)]
struct Shared {
    book: Mutex<Book>,
    /// Goes up whenever the book changes.
    edition: AtomicU64,
    /// Queues that the server does not know of yet.
    feeds: Mutex<Vec<Taken>>,
    /// A bit for each topic that somebody listens to, see [`bit`].
    wanted: AtomicU64,
    clients: AtomicU64,
    subscriptions: Mutex<u64>,
    subscribed: Condvar,
    sent: AtomicU64,
    dropped: AtomicU64,
    missed: AtomicU64,
    /// Shall the thread end?
    ends: AtomicBool,
    /// Is there nothing left that could be sent? Answered in this many rounds of the thread.
    settled: Mutex<Settled>,
    quiet: Condvar,
}

/// Asks the thread to send what there is.
#[derive(Default)]
struct Settled {
    asked: u64,
    answered: u64,
}

/// The bit of a topic; those that there are too many of share the last.
fn bit(channel: u32) -> u64 {
    1 << channel.min(63)
}

/// What another thread left when it panicked is still counts and lists.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Live {
    /// Listens; port 0 takes a free one.
    ///
    /// # Errors
    /// The address is not on loopback, or cannot be listened on.
    pub fn start(address: SocketAddr) -> Result<Self, LinkError> {
        if !address.ip().is_loopback() {
            return Err(LinkError::NotLoopback(address));
        }
        let listener = TcpListener::bind(address);
        let failed = |source| LinkError::Io { what: "listen on", address, source };
        let listener = listener.map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let at = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared::default());
        let hub = Hub::new(listener, shared.clone());
        let thread = std::thread::Builder::new().name("live".into()).spawn(move || hub.run()).map_err(failed)?;
        Ok(Live { shared, at, thread: Some(thread) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.at
    }

    /// For the log of a run: what that log gets, the clients get. A new one closes topics that it does not have itself; time may
    /// begin anew, or go back.
    pub fn outlet(&self) -> Box<dyn MessageSink> {
        let (feed, taken) = Feed::new(self.shared.clone());
        lock(&self.shared.feeds).push(taken);
        Box::new(feed)
    }

    /// How often somebody began to listen to a topic. When it goes up while nothing moves, what there is to see may be told again.
    pub fn subscriptions(&self) -> u64 {
        *lock(&self.shared.subscriptions)
    }

    /// Waits until somebody listens to something, at most `patience`, or until `cancel`. Did somebody?
    pub fn wait(&self, patience: Duration, cancel: &AtomicBool) -> bool {
        let end = Instant::now() + patience;
        let mut count = lock(&self.shared.subscriptions);
        while *count == 0 {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() || cancel.load(Relaxed) {
                return false;
            }
            count =
                self.shared.subscribed.wait_timeout(count, left.min(SLICE)).unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }

    /// Waits until what was handed over is sent; clients that do not read for half a second are not waited for.
    pub fn settle(&self) -> Told {
        let mut settled = lock(&self.shared.settled);
        settled.asked += 1;
        let wanted = settled.asked;
        self.wake();
        while settled.answered < wanted && self.thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            settled = self.shared.quiet.wait_timeout(settled, SLICE).unwrap_or_else(PoisonError::into_inner).0;
        }
        drop(settled);
        self.told()
    }

    /// What was sent so far.
    pub fn told(&self) -> Told {
        let s = &self.shared;
        let [clients, sent, dropped, missed] = [&s.clients, &s.sent, &s.dropped, &s.missed].map(|n| n.load(Relaxed));
        Told { clients, sent, dropped, missed }
    }

    fn wake(&self) {
        self.thread.iter().for_each(|thread| thread.thread().unpark());
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.ends.store(true, Relaxed);
        self.wake();
        if let Some(thread) = self.thread.take() {
            // It only reads: whatever became of it, the run is whole.
            let _ = thread.join();
        }
    }
}
