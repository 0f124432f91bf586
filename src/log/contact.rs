//! `/contact`: state, vertices and forces of every sole.

use crate::files::RecordError;
use crate::log::Topic;
use crate::log::convert::{own, own_all};
use crate::log::messages::{Contact, Sole};
use crate::log::sink::{Channel, Sink};
use crate::robot::Model;
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct ContactTopic {
    channel: Channel,
    message: Contact,
}

impl ContactTopic {
    pub fn open(sink: &mut Sink, model: &Model) -> Result<Self, RecordError> {
        let soles = model.soles.iter().map(|s| Sole { name: s.name.clone(), ..Default::default() }).collect();
        Ok(Self { channel: sink.own("/contact", "Contact", BTreeMap::new())?, message: Contact { time: 0.0, soles } })
    }
}

impl Topic for ContactTopic {
    fn record(&mut self, time: u64, s: &Snapshot, sink: &mut Sink) -> Result<(), RecordError> {
        self.message.time = s.time;
        for (to, from) in self.message.soles.iter_mut().zip(&s.soles) {
            to.state.clone_from(&from.state);
            to.clamped.clone_from(&from.clamped);
            own_all(&from.positions, &mut to.positions);
            own_all(&from.velocities, &mut to.velocities);
            own_all(&from.forces, &mut to.forces);
            to.force = Some(own(&from.forces.iter().sum()));
        }
        sink.send(&mut self.channel, time, &self.message)
    }
}
