//! Bounds the connections of a server: number, time and rate.
//!
//! Each connection has a deadline. A request must be complete within a fixed time, and a response
//! must be read at a minimum rate. When there are too many connections, a new one replaces the one
//! that is due first, so clients that hold connections open do not keep others out.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Largest part of a response that is written at once, bytes.
const PIECE: usize = 64 << 10;
/// Longest wait between checks of waiting connections.
const SLICE: Duration = Duration::from_millis(100);

/// Limits of a server's connections.
#[derive(Clone, Copy, Debug)]
pub struct ConnectionLimits {
    /// Largest number of connections.
    pub connections: usize,
    /// Largest number of runs that are read and sent at the same time; less than `connections`.
    pub transfers: usize,
    /// Time from the start of a connection to the end of its request.
    pub request: Duration,
    /// Longest time that a response may lag behind `rate`.
    pub lag: Duration,
    /// Lowest rate at which a client must read, bytes per second.
    pub rate: f64,
    /// Time without progress after which a transfer may be replaced by one that waits.
    pub stalled: Duration,
}

impl Default for ConnectionLimits {
    fn default() -> Self {
        Self {
            connections: 64,
            // Browsers open six connections.
            transfers: 8,
            request: Duration::from_secs(10),
            lag: Duration::from_secs(10),
            rate: (64 << 10) as f64,
            stalled: Duration::from_secs(1),
        }
    }
}

/// The connections of a server.
pub(super) struct Connections {
    limits: ConnectionLimits,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    last_id: u64,
    entries: Vec<Entry>,
}

struct Entry {
    id: u64,
    stream: Arc<TcpStream>,
    stage: Stage,
    deadline: Instant,
    /// Instant of the last progress.
    progress: Instant,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Reads the request, waits, or sends a page.
    Request,
    /// Reads a run; not replaced, as this ends by itself.
    Packing,
    /// Sends a run.
    Transfer,
}

/// A connection; dropping it makes room for another.
pub(super) struct Connection {
    all: Arc<Connections>,
    stream: Arc<TcpStream>,
    id: u64,
    deadline: Instant,
}

impl Connections {
    pub fn new(limits: ConnectionLimits) -> Arc<Self> {
        Arc::new(Self { limits, state: Mutex::default(), changed: Condvar::new() })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection. If there are too many, the one that is due first is closed.
    pub fn add(self: &Arc<Self>, stream: TcpStream) -> Connection {
        let stream = Arc::new(stream);
        let now = Instant::now();
        let deadline = now + self.limits.request;
        let mut state = self.lock();
        if state.entries.len() >= self.limits.connections {
            let replaceable = state.entries.iter().enumerate().filter(|(_, entry)| entry.stage != Stage::Packing);
            if let Some(at) = replaceable.min_by_key(|(_, entry)| entry.deadline).map(|(at, _)| at) {
                state.close(at);
                self.changed.notify_all();
            }
        }
        state.last_id += 1;
        let id = state.last_id;
        state.entries.push(Entry { id, stream: stream.clone(), stage: Stage::Request, deadline, progress: now });
        Connection { all: self.clone(), stream, id, deadline }
    }
}

impl State {
    fn entry(&mut self, id: u64) -> Option<&mut Entry> {
        self.entries.iter_mut().find(|entry| entry.id == id)
    }

    /// Closes a connection; its thread then fails to read or write.
    fn close(&mut self, at: usize) {
        let _ = self.entries.remove(at).stream.shutdown(Shutdown::Both);
    }
}

impl Connection {
    /// Starts the time of the response.
    pub fn begin_response(&mut self) {
        self.deadline = Instant::now() + self.all.limits.lag;
        self.update(|_| ());
    }

    /// Waits until a run may be read and sent. Returns false if the connection was closed meanwhile.
    /// If all transfers are in use, replaces the one that has made no progress for longest.
    pub fn begin_transfer(&mut self) -> bool {
        let all = self.all.clone();
        let mut state = all.lock();
        loop {
            let used = state.entries.iter().filter(|entry| entry.stage != Stage::Request).count();
            let Some(entry) = state.entry(self.id) else { return false };
            if used < all.limits.transfers {
                entry.stage = Stage::Packing;
                return true;
            }
            let sending = state.entries.iter().enumerate().filter(|(_, entry)| entry.stage == Stage::Transfer);
            let slowest = sending.min_by_key(|(_, entry)| entry.progress).map(|(at, entry)| (at, entry.progress));
            match slowest {
                Some((at, progress)) if progress.elapsed() >= all.limits.stalled => state.close(at),
                _ => state = all.changed.wait_timeout(state, SLICE).unwrap_or_else(PoisonError::into_inner).0,
            }
        }
    }

    /// Starts the time of a response whose run has been read.
    pub fn begin_sending(&mut self) {
        self.begin_response();
        self.update(|entry| entry.stage = Stage::Transfer);
    }

    /// Publishes the deadline and a change of the entry.
    fn update(&self, change: impl FnOnce(&mut Entry)) {
        if let Some(entry) = self.all.lock().entry(self.id) {
            (entry.deadline, entry.progress) = (self.deadline, Instant::now());
            change(entry);
        }
    }

    /// Time until the deadline.
    fn remaining(&self) -> io::Result<Duration> {
        let remaining = self.deadline.saturating_duration_since(Instant::now());
        if remaining.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(remaining) }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.all.lock().entries.retain(|entry| entry.id != self.id);
        self.all.changed.notify_all();
    }
}

impl Read for &mut Connection {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(self.remaining()?))?;
        (&*self.stream).read(bytes)
    }
}

impl Write for &mut Connection {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(Some(self.remaining()?))?;
        let count = (&*self.stream).write(&bytes[..bytes.len().min(PIECE)])?;
        let limits = self.all.limits;
        let earned = Duration::from_secs_f64(count as f64 / limits.rate);
        self.deadline = (self.deadline + earned).min(Instant::now() + limits.lag);
        self.update(|_| ());
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    /// Longer than any test takes.
    const LONG: Duration = Duration::from_secs(600);

    fn limits(connections: usize, transfers: usize) -> ConnectionLimits {
        ConnectionLimits { connections, transfers, request: LONG, lag: LONG, rate: 1.0, stalled: Duration::ZERO }
    }

    /// Both ends of a connection, the client's first.
    fn pair() -> (TcpStream, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        (client, listener.accept().unwrap().0)
    }

    fn is_open(client: &TcpStream) -> bool {
        client.set_nonblocking(true).unwrap();
        client.peek(&mut [0]).is_err_and(|error| error.kind() == ErrorKind::WouldBlock)
    }

    #[test]
    fn a_new_connection_replaces_the_one_that_is_due_first() {
        let all = Connections::new(limits(3, 2));
        let pairs: Vec<_> = (0..5).map(|_| pair()).collect();
        let (clients, streams): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        let mut added = Vec::new();
        for (at, stream) in streams.into_iter().enumerate() {
            added.push(all.add(stream));
            // The first gets further, so the others are due before it.
            if at == 0 {
                assert!(added[0].begin_transfer());
            }
            if at == 2 {
                added[0].begin_sending();
            }
        }
        assert_eq!(clients.iter().map(is_open).collect::<Vec<_>>(), [true, false, false, true, true]);
        assert!(!added[1].begin_transfer(), "it is closed");
        drop(added);
        assert!(all.lock().entries.is_empty());
    }

    #[test]
    fn a_run_that_is_read_is_not_replaced() {
        let all = Connections::new(limits(1, 1));
        let ((first, one), (second, two)) = (pair(), pair());
        let mut one = all.add(one);
        assert!(one.begin_transfer());
        let _two = all.add(two);
        assert!(is_open(&first) && is_open(&second));
    }

    #[test]
    fn a_client_that_reads_nothing_loses_its_transfer_to_another() {
        let all = Connections::new(limits(9, 1));
        let ((client, one), (_other, two)) = (pair(), pair());
        let (mut one, mut two) = (all.add(one), all.add(two));
        assert!(one.begin_transfer());
        one.begin_sending();
        let writer = std::thread::spawn(move || (&mut one).write_all(&vec![0; 64 << 20]));
        assert!(two.begin_transfer());
        assert!(writer.join().unwrap().is_err());
        drop(client);
    }

    #[test]
    fn a_response_that_nobody_reads_ends_at_its_deadline() {
        let lag = Duration::from_millis(20);
        let all = Connections::new(ConnectionLimits { lag, ..limits(9, 1) });
        let (client, stream) = pair();
        let mut connection = all.add(stream);
        connection.begin_response();
        let error = (&mut connection).write_all(&vec![0; 64 << 20]).unwrap_err();
        assert!(matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock), "{error}");
        drop(client);
    }

    #[test]
    fn a_request_has_one_deadline_for_all_its_bytes() {
        let request = Duration::from_millis(50);
        let all = Connections::new(ConnectionLimits { request, ..limits(9, 1) });
        let (mut client, stream) = pair();
        let mut connection = all.add(stream);
        let error = loop {
            client.write_all(b"a").unwrap();
            match (&mut connection).read(&mut [0; 9]) {
                Ok(count) => assert_eq!(count, 1),
                Err(error) => break error,
            }
        };
        assert!(matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock), "{error}");
    }
}
