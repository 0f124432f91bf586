//! Writes `/objects`: the pose of every link of an object.

use crate::files::RecordError;
use crate::log::messages::Objects;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::Link;
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct ObjectsTopic {
    channel: Channel,
    message: Objects,
}

impl ObjectsTopic {
    pub fn open(output: &mut LogOutput, objects: &[Link]) -> Result<Self, RecordError> {
        let names: Vec<&str> = objects.iter().map(|link| link.name.as_str()).collect();
        let metadata = BTreeMap::from([("objects".to_owned(), serde_json::json!(names).to_string())]);
        Ok(Self { channel: output.stiction("/objects", "Objects", metadata)?, message: Objects::default() })
    }
}

impl Topic for ObjectsTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        self.message.time = s.time;
        self.message.poses.clear();
        for pose in &s.object_poses {
            let (p, q) = (&pose.translation.vector, &pose.rotation);
            self.message.poses.extend([p.x, p.y, p.z, q.w, q.i, q.j, q.k]);
        }
        output.send(&mut self.channel, time, &self.message)
    }
}
