//! Rules for `[[event]]`.

use super::Check;
use crate::scenario::format::event::EventSpec;

/// Greatest number of events; a whole scenario is stored for each.
const MAX_EVENTS: usize = 1000;

impl Check<'_> {
    /// Warns when `stop.at` is after the end of the run and has no effect.
    pub(super) fn stop_time(&mut self, at: Option<f64>, duration: f64) {
        if let Some(at) = at.filter(|at| *at > duration) {
            let message = format!("`stop.at` is at {at} s, but the run ends at {duration} s, its `duration`");
            self.warning("stop.at", message);
        }
    }

    /// `tasks` is the number of tasks, `end` the end of the run, s.
    pub(super) fn events(&mut self, events: &[EventSpec], tasks: usize, end: f64) {
        if events.len() > MAX_EVENTS {
            return self.error("event", format!("has {} entries, at most {MAX_EVENTS} are allowed", events.len()));
        }
        for (i, event) in events.iter().enumerate() {
            let path = format!("event.{i}");
            if event.set.is_empty() && event.end_tasks.is_empty() && event.save.is_none() && event.restore.is_none() {
                self.error(&path, "needs `set`, `end_tasks`, `save` or `restore`");
            }
            for (k, number) in event.end_tasks.iter().enumerate().filter(|(_, number)| **number >= tasks) {
                let existing = match tasks {
                    0 => "there are none".to_owned(),
                    1 => "there is only task 0".to_owned(),
                    _ => format!("there are tasks 0 to {}", tasks - 1),
                };
                self.error(&format!("{path}.end_tasks.{k}"), format!("names task {number}, but {existing}"));
            }
            if event.at >= end {
                let message = format!("`{path}` is at {} s, but the run ends at {end} s", event.at);
                self.warning(&format!("{path}.at"), message);
            }
            if event.save.as_deref() == Some("") {
                self.error(&format!("{path}.save"), "must be a name of at least one character");
            }
            let Some(name) = &event.restore else { continue };
            // At one instant events happen in the order of the file; an event saves before it
            // restores.
            let saves = |(k, other): (usize, &EventSpec)| {
                other.save.as_ref() == Some(name) && (other.at < event.at || other.at == event.at && k <= i)
            };
            if !events.iter().enumerate().any(saves) {
                self.error(&format!("{path}.restore"), format!("names `{name}`, which no earlier event saves"));
            }
        }
    }
}
