//! Writes events: `/events` for programs, `/log` as text for viewers.

use crate::files::RecordError;
use crate::log::messages::Event;
use crate::log::write::conversion::{nanoseconds, timestamp};
use crate::log::write::log_output::{Channel, LogOutput};
use crate::sim::SimEvent;
use foxglove::messages::{Log, log::Level};
use std::collections::BTreeMap;

pub(super) struct EventTopics {
    events: Channel,
    log: Channel,
}

impl EventTopics {
    pub fn open(output: &mut LogOutput) -> Result<Self, RecordError> {
        Ok(Self { events: output.stiction("/events", "Event", BTreeMap::new())?, log: output.foxglove::<Log>("/log")? })
    }

    pub fn record(&mut self, e: &SimEvent, output: &mut LogOutput) -> Result<(), RecordError> {
        let time = nanoseconds(e.time);
        let event = Event {
            time: e.time,
            kind: e.kind.as_str().to_owned(),
            subject: e.subject.clone(),
            message: e.message.clone(),
        };
        output.send(&mut self.events, time, &event)?;
        let log = Log {
            timestamp: Some(timestamp(time)),
            level: level(e.kind.as_str()).into(),
            message: if e.message.is_empty() { format!("{} {}", e.kind, e.subject) } else { e.message.clone() },
            name: e.kind.as_str().to_owned(),
            ..Default::default()
        };
        output.send(&mut self.log, time, &log)
    }
}

/// Severity with which viewers highlight an event.
fn level(kind: &str) -> Level {
    match kind {
        "inconsistent" => Level::Error,
        "jam" | "fallen" => Level::Warning,
        _ => Level::Info,
    }
}
