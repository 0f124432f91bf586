//! `/events`: what happened, for programs; `/log`: the same for people.

use crate::files::RecordError;
use crate::log::convert::{nanoseconds, timestamp};
use crate::log::messages::Event;
use crate::log::sink::{Channel, Sink};
use crate::sim::SimEvent;
use foxglove::messages::{Log, log::Level};
use std::collections::BTreeMap;

pub(super) struct EventTopics {
    events: Channel,
    log: Channel,
}

impl EventTopics {
    pub fn open(sink: &mut Sink) -> Result<Self, RecordError> {
        Ok(Self { events: sink.own("/events", "Event", BTreeMap::new())?, log: sink.foxglove::<Log>("/log")? })
    }

    pub fn record(&mut self, e: &SimEvent, sink: &mut Sink) -> Result<(), RecordError> {
        let time = nanoseconds(e.time);
        let event =
            Event { time: e.time, kind: e.kind.to_owned(), subject: e.subject.clone(), message: e.message.clone() };
        sink.send(&mut self.events, time, &event)?;
        let log = Log {
            timestamp: Some(timestamp(time)),
            level: level(e.kind).into(),
            message: if e.message.is_empty() { format!("{} {}", e.kind, e.subject) } else { e.message.clone() },
            name: e.kind.to_owned(),
            ..Default::default()
        };
        sink.send(&mut self.log, time, &log)
    }
}

/// What a viewer should make stand out.
fn level(kind: &str) -> Level {
    match kind {
        "inconsistent" => Level::Error,
        "jam" | "fallen" => Level::Warning,
        _ => Level::Info,
    }
}
