//! Writes `/contact`: state, vertices and forces of every sole, and of other links that touch.

use crate::files::RecordError;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::proto_writer::ProtoWriter;
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::{Snapshot, SoleSnapshot};
use std::collections::BTreeMap;

pub(super) struct ContactTopic {
    channel: Channel,
    /// Names of the soles.
    soles: Vec<String>,
}

impl ContactTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let soles = model.soles.iter().map(|s| s.name.clone()).collect();
        Ok(Self { channel: output.stiction("/contact", "Contact", BTreeMap::new())?, soles })
    }
}

impl Topic for ContactTopic {
    /// Fields as in [`Contact`](crate::log::messages::Contact).
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        output.send_fields(&mut self.channel, time, |to| {
            to.double(1, s.time);
            for (name, sole) in self.soles.iter().zip(&s.soles) {
                to.message(2, |to| write_sole(name, sole, to));
            }
            for (name, link) in &s.links {
                to.message(3, |to| write_sole(name, link, to));
            }
        })
    }
}

/// Fields as in [`Sole`](crate::log::messages::Sole).
fn write_sole(name: &str, sole: &SoleSnapshot, to: &mut ProtoWriter) {
    to.text(1, name);
    to.text(2, &sole.state);
    to.bools(3, &sole.clamped);
    to.vectors(4, &sole.positions);
    to.vectors(5, &sole.velocities);
    to.vectors(6, &sole.forces);
    to.vector(7, &sole.forces.iter().sum());
}
