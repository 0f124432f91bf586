//! Observer of a session's simulation: keeps the newest events, writes the recording and the live
//! stream.

use std::collections::VecDeque;

use crate::log::LogWriter;
use crate::sim::{Observer, ObserverError, SimEvent, Snapshot};

/// Largest number of events kept for `events`.
const MAX_EVENTS: usize = 10_000;

/// Observer of a session's simulation.
#[derive(Default)]
pub struct SessionObserver {
    /// Active recording.
    pub log: Option<LogWriter>,
    /// Log streamed to live clients.
    pub live_log: Option<LogWriter>,
    /// Number of instants in the recording.
    pub instants: u64,
    /// Time of its last instant, s.
    pub last: Option<f64>,
    /// The newest events.
    pub events: VecDeque<SimEvent>,
    /// Number of events so far.
    pub count: u64,
}

impl SessionObserver {
    /// Events after the first `since` ones, if they are kept.
    pub fn since(&self, since: u64) -> impl Iterator<Item = &SimEvent> {
        let new = (self.count - since).min(self.events.len() as u64) as usize;
        self.events.iter().skip(self.events.len() - new)
    }
}

impl Observer for SessionObserver {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), ObserverError> {
        self.live_log.as_mut().map_or(Ok(()), |live| live.snapshot(snapshot))?;
        let Some(log) = &mut self.log else { return Ok(()) };
        self.instants += 1;
        self.last = Some(snapshot.time);
        log.snapshot(snapshot)
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), ObserverError> {
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
        self.count += 1;
        self.live_log.as_mut().map_or(Ok(()), |live| live.event(event))?;
        self.log.as_mut().map_or(Ok(()), |log| log.event(event))
    }
}
