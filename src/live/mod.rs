//! Streams the topics of a log over a WebSocket on loopback while the run is simulated, in
//! Foxglove's protocol.
//!
//! ```text
//! simulation -> Feed -> bounded queue -> thread (hub) -> bounded backlog per client -> socket
//!                 ^--- empty instants <---'
//! ```
//!
//! The simulation thread hands over encoded messages, one log instant at a time, and reuses the
//! memory of sent ones. It makes no system call, never waits, and encodes only topics that a client
//! has subscribed to. A full queue drops an instant; a slow client loses its oldest messages. Both
//! losses are counted.
//!
//! The server of the `foxglove` crate is not used: it does not count dropped messages, keeps no
//! description of a run for clients that connect later, closes without sending what is queued,
//! checks neither Host nor Origin, and adds an asynchronous runtime and 24 crates.
//!
//! Imports: `web`, `log`, `remote`. Used by: `cli`.

mod client;
mod client_bytes;
mod feed;
mod handshake;
mod hub;
mod protocol;
mod topic_registry;

use std::fmt;
use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::log::MessageSink;
use crate::remote::{LinkError, nonce};
use crate::web::{AccessError, LocalAccess};
#[doc(hidden)]
pub use client_bytes::read_client_bytes;
use feed::{Feed, FeedReceiver};
pub use handshake::{HandshakeResult, parse_handshake};
use hub::Hub;
pub use protocol::{Request, Subscription, parse_request};
use topic_registry::TopicRegistry;

/// Origins of viewers that are permitted by default: Foxglove, Lichtblick, and desktop programs,
/// whose pages are files. A sandboxed page of any site has the origin `null`, which is not permitted.
pub const VIEWER_ORIGINS: [&str; 4] =
    ["https://app.foxglove.dev", "https://studio.foxglove.dev", "https://lichtblick-suite.github.io", "file://"];

/// Longest wait between checks for cancellation.
const SLICE: Duration = Duration::from_millis(50);

/// A server on loopback with its own thread. Dropping it closes the connections.
pub struct LiveServer {
    shared: Arc<Shared>,
    at: SocketAddr,
    thread: Option<JoinHandle<()>>,
}

/// Numbers of messages and clients so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransferCounts {
    /// Clients that connected.
    pub clients: u64,
    /// Messages sent, counted once per client.
    pub sent: u64,
    /// Messages dropped because a client read too slowly.
    pub dropped: u64,
    /// Messages dropped for all clients because the server was too slow.
    pub missed: u64,
    /// Clients refused because of their host or origin.
    pub refused: u64,
}

impl fmt::Display for TransferCounts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let TransferCounts { clients, sent, dropped, missed, refused } = self;
        let plural = if *clients == 1 { "client" } else { "clients" };
        write!(
            f,
            "{clients} {plural}, {sent} messages sent, {dropped} dropped for slow readers, {missed} not taken in time"
        )?;
        if *refused > 0 { write!(f, ", {refused} refused") } else { Ok(()) }
    }
}

/// State shared by the simulation thread and the server thread.
#[derive(Default)]
struct Shared {
    registry: Mutex<TopicRegistry>,
    /// Incremented whenever the registry changes.
    version: AtomicU64,
    /// Queues that the server has not taken over yet.
    feeds: Mutex<Vec<FeedReceiver>>,
    /// One bit per topic with a subscriber, see [`bit`].
    subscribed_topics: AtomicU64,
    clients: AtomicU64,
    subscriptions: Mutex<u64>,
    subscribed: Condvar,
    sent: AtomicU64,
    dropped: AtomicU64,
    missed: AtomicU64,
    refused: AtomicU64,
    /// True once the thread must end.
    stop: AtomicBool,
    flushes: Mutex<Flushes>,
    flushed: Condvar,
}

/// Flushes that were requested and completed.
#[derive(Default)]
struct Flushes {
    requested: u64,
    done: u64,
}

/// Bit of a topic. Topics beyond the number of bits share the last one.
fn bit(channel: u32) -> u64 {
    1 << channel.min(63)
}

/// Locks a mutex. Counts and lists stay valid when another thread panics.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl LiveServer {
    /// Starts to listen for clients on loopback and of [`VIEWER_ORIGINS`]. Port 0 selects a free
    /// port.
    ///
    /// # Errors
    /// The address is not on loopback, or cannot be listened on.
    pub fn start(address: SocketAddr) -> Result<Self, LinkError> {
        Self::start_with(address, LocalAccess::default(), Box::new(|_| ()))
    }

    /// Like [`start`](Self::start), and permits other hosts and origins. Calls `on_refusal` for each
    /// client that is not permitted.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn start_with(
        address: SocketAddr,
        mut access: LocalAccess,
        on_refusal: Box<dyn FnMut(&AccessError) + Send>,
    ) -> Result<Self, LinkError> {
        access.origins.extend(VIEWER_ORIGINS.map(str::to_owned));
        if !address.ip().is_loopback() {
            return Err(LinkError::NotLoopback(address));
        }
        let listener = TcpListener::bind(address);
        let failed = |source| LinkError::Io { what: "listen on", address, source };
        let listener = listener.map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let at = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared::default());
        let hub = Hub::new(listener, (access, on_refusal), shared.clone(), nonce()?);
        let thread = std::thread::Builder::new().name("live".into()).spawn(move || hub.run()).map_err(failed)?;
        Ok(LiveServer { shared, at, thread: Some(thread) })
    }

    /// Address on which it listens.
    pub fn address(&self) -> SocketAddr {
        self.at
    }

    /// Creates a sink for the log of a run, whose messages go to the clients. A new sink closes the
    /// topics that its run does not have; its time may start again or go back.
    pub fn sink(&self) -> Box<dyn MessageSink> {
        let (feed, receiver) = Feed::new(self.shared.clone());
        lock(&self.shared.feeds).push(receiver);
        Box::new(feed)
    }

    /// Number of subscriptions so far. When it increases while the run is held, the present state
    /// should be sent again.
    pub fn subscriptions(&self) -> u64 {
        *lock(&self.shared.subscriptions)
    }

    /// Waits until a client has subscribed, at most `limit`, or until `cancel`. Returns whether one
    /// has.
    pub fn wait(&self, limit: Duration, cancel: &AtomicBool) -> bool {
        let end = Instant::now() + limit;
        let mut count = lock(&self.shared.subscriptions);
        while *count == 0 {
            let remaining = end.saturating_duration_since(Instant::now());
            if remaining.is_zero() || cancel.load(Relaxed) {
                return false;
            }
            count = self
                .shared
                .subscribed
                .wait_timeout(count, remaining.min(SLICE))
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
        true
    }

    /// Waits until all messages are sent. Clients that do not read for half a second lose theirs.
    pub fn flush(&self) -> TransferCounts {
        let mut flushes = lock(&self.shared.flushes);
        flushes.requested += 1;
        let target = flushes.requested;
        self.wake();
        while flushes.done < target && self.thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            flushes = self.shared.flushed.wait_timeout(flushes, SLICE).unwrap_or_else(PoisonError::into_inner).0;
        }
        drop(flushes);
        self.counts()
    }

    /// Numbers of messages and clients so far.
    pub fn counts(&self) -> TransferCounts {
        let s = &self.shared;
        let [clients, sent, dropped, missed, refused] =
            [&s.clients, &s.sent, &s.dropped, &s.missed, &s.refused].map(|n| n.load(Relaxed));
        TransferCounts { clients, sent, dropped, missed, refused }
    }

    fn wake(&self) {
        self.thread.iter().for_each(|thread| thread.thread().unpark());
    }
}

impl Drop for LiveServer {
    fn drop(&mut self) {
        self.shared.stop.store(true, Relaxed);
        self.wake();
        if let Some(thread) = self.thread.take() {
            // The run does not depend on the server, even if its thread panicked.
            let _ = thread.join();
        }
    }
}
