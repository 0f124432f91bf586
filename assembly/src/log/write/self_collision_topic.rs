//! Writes `/self_collision`: the nearest pair of the robot's bodies and the state of avoidance.

use crate::files::RecordError;
use crate::log::messages::SelfCollision;
use crate::log::write::conversion::to_message;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct SelfCollisionTopic {
    /// Opened by the first snapshot with distances.
    channel: Option<Channel>,
    metadata: BTreeMap<String, String>,
    message: SelfCollision,
}

impl SelfCollisionTopic {
    pub fn new(model: &Model) -> Self {
        let joints: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let metadata = BTreeMap::from([("joints".to_owned(), serde_json::json!(joints).to_string())]);
        Self { channel: None, metadata, message: SelfCollision::default() }
    }
}

impl Topic for SelfCollisionTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let Some(now) = &s.self_contact else { return Ok(()) };
        let channel = match &mut self.channel {
            Some(channel) => channel,
            none => none.insert(output.stiction("/self_collision", "SelfCollision", self.metadata.clone())?),
        };
        let m = &mut self.message;
        m.time = s.time;
        (m.distance, m.first, m.second) = (f64::INFINITY, String::new(), String::new());
        (m.on_first, m.on_second) = (None, None);
        if let Some((distance, pair, a, b)) = &now.nearest {
            let [first, second] = &now.pairs[*pair];
            m.distance = *distance;
            m.first.clone_from(first);
            m.second.clone_from(second);
            (m.on_first, m.on_second) = (Some(to_message(a)), Some(to_message(b)));
        }
        (m.cycles, m.tests) = (now.cycles, now.tests);
        m.frozen.clone_from(&now.frozen);
        m.wanted.clone_from(&now.desired);
        output.send(channel, time, m)
    }
}
