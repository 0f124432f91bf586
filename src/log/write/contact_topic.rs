//! Writes `/contact`: state, vertices and forces of every sole, and of other links that touch.

use crate::files::RecordError;
use crate::log::messages::{Contact, Sole};
use crate::log::write::conversion::{to_message, to_messages};
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::{Snapshot, SoleSnapshot};
use std::collections::BTreeMap;

pub(super) struct ContactTopic {
    channel: Channel,
    message: Contact,
}

impl ContactTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let soles = model.soles.iter().map(|s| Sole { name: s.name.clone(), ..Default::default() }).collect();
        Ok(Self {
            channel: output.stiction("/contact", "Contact", BTreeMap::new())?,
            message: Contact { time: 0.0, soles, links: Vec::new() },
        })
    }
}

impl Topic for ContactTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        self.message.time = s.time;
        for (to, from) in self.message.soles.iter_mut().zip(&s.soles) {
            fill(from, to);
        }
        self.message.links.resize_with(s.links.len(), Sole::default);
        for (to, (name, from)) in self.message.links.iter_mut().zip(&s.links) {
            to.name.clone_from(name);
            fill(from, to);
        }
        output.send(&mut self.channel, time, &self.message)
    }
}

fn fill(from: &SoleSnapshot, to: &mut Sole) {
    to.state.clone_from(&from.state);
    to.clamped.clone_from(&from.clamped);
    to_messages(&from.positions, &mut to.positions);
    to_messages(&from.velocities, &mut to.velocities);
    to_messages(&from.forces, &mut to.forces);
    to.force = Some(to_message(&from.forces.iter().sum()));
}
