//! Rules for `[[event]]`.

use super::Check;
use crate::scenario::format::event::EventSpec;

/// The whole scenario is kept for each event.
const MOST_EVENTS: usize = 1000;

impl Check<'_> {
    /// `end` is the run's, s.
    /// Warns when `stop.at` is after the end and has no effect.
    pub(super) fn end(&mut self, at: Option<f64>, duration: f64) {
        if let Some(at) = at.filter(|at| *at > duration) {
            let span = self.spans("stop.at").1;
            let message = format!("`stop.at` is at {at} s, but the run ends at {duration} s, its `duration`");
            self.findings.warning(span, message, None);
        }
    }

    pub(super) fn events(&mut self, events: &[EventSpec], tasks: usize, end: f64) {
        if events.len() > MOST_EVENTS {
            return self.error("event", format!("has {} entries, at most {MOST_EVENTS} are allowed", events.len()));
        }
        for (i, event) in events.iter().enumerate() {
            let path = format!("event.{i}");
            if event.set.is_empty() && event.end_tasks.is_empty() && event.save.is_none() && event.restore.is_none() {
                self.error(&path, "needs `set`, `end_tasks`, `save` or `restore`");
            }
            for (k, number) in event.end_tasks.iter().enumerate().filter(|(_, number)| **number >= tasks) {
                let there = match tasks {
                    0 => "there are none".to_owned(),
                    1 => "there is only task 0".to_owned(),
                    _ => format!("there are tasks 0 to {}", tasks - 1),
                };
                self.error(&format!("{path}.end_tasks.{k}"), format!("names task {number}, but {there}"));
            }
            if event.at >= end {
                let span = self.spans(&format!("{path}.at")).1;
                let message = format!("`{path}` is at {} s, but the run ends at {end} s", event.at);
                self.findings.warning(span, message, None);
            }
            if event.save.as_deref() == Some("") {
                self.error(&format!("{path}.save"), "must be a name of at least one character");
            }
            let Some(name) = &event.restore else { continue };
            // At one instant events happen in the order of the file; within one the state is saved first.
            let saves = |(k, other): (usize, &EventSpec)| {
                other.save.as_ref() == Some(name) && (other.at < event.at || other.at == event.at && k <= i)
            };
            if !events.iter().enumerate().any(saves) {
                self.error(&format!("{path}.restore"), format!("names `{name}`, which no earlier event saves"));
            }
        }
    }
}
