//! What a session hears of its simulation.

use std::collections::VecDeque;

use crate::log::LogWriter;
use crate::sim::{Observer, SimEvent, Snapshot};

/// Events that are kept for `events`.
const MOST: usize = 10_000;

/// See the module.
#[derive(Default)]
pub struct Tap {
    /// The recording that is being made.
    pub log: Option<LogWriter>,
    /// What people who look on are told.
    pub shown: Option<LogWriter>,
    /// Instants in it.
    pub instants: u64,
    /// Time of the last of them, s.
    pub last: Option<f64>,
    /// The newest events.
    pub events: VecDeque<SimEvent>,
    /// How many there have been.
    pub count: u64,
}

impl Tap {
    /// The events since the count was `since`, those that are still kept.
    pub fn since(&self, since: u64) -> impl Iterator<Item = &SimEvent> {
        let new = (self.count - since).min(self.events.len() as u64) as usize;
        self.events.iter().skip(self.events.len() - new)
    }
}

impl Observer for Tap {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        self.shown.as_mut().map_or(Ok(()), |shown| shown.snapshot(snapshot))?;
        let Some(log) = &mut self.log else { return Ok(()) };
        self.instants += 1;
        self.last = Some(snapshot.time);
        log.snapshot(snapshot)
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), String> {
        if self.events.len() == MOST {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
        self.count += 1;
        self.shown.as_mut().map_or(Ok(()), |shown| shown.event(event))?;
        self.log.as_mut().map_or(Ok(()), |log| log.event(event))
    }
}
