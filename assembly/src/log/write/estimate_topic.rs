//! Writes `/estimate`: sensor readings and state estimate, next to the true state in `/state`.

use crate::files::RecordError;
use crate::log::messages::{Estimate, Quaternion, Wrench};
use crate::log::write::conversion::to_message;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::Snapshot;
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;

pub(super) struct EstimateTopic {
    /// Opened by the first snapshot with an estimate.
    channel: Option<Channel>,
    metadata: BTreeMap<String, String>,
    message: Estimate,
}

impl EstimateTopic {
    pub fn new(model: &Model) -> Self {
        let list = |names: Vec<&str>| serde_json::json!(names).to_string();
        let metadata = BTreeMap::from([
            ("joints".to_owned(), list(model.joints.iter().map(|j| j.name.as_str()).collect())),
            ("soles".to_owned(), list(model.soles.iter().map(|s| s.name.as_str()).collect())),
        ]);
        Self { channel: None, metadata, message: Estimate::default() }
    }
}

fn quaternion(r: &UnitQuaternion<f64>) -> Quaternion {
    Quaternion { w: r.w, x: r.i, y: r.j, z: r.k }
}

impl Topic for EstimateTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let Some(e) = &s.estimate else { return Ok(()) };
        let channel = match &mut self.channel {
            Some(channel) => channel,
            none => none.insert(output.stiction("/estimate", "Estimate", self.metadata.clone())?),
        };
        let m = &mut self.message;
        (m.time, m.tick) = (s.time, e.time);
        m.base_position = Some(to_message(&e.base_pose.translation.vector));
        m.base_orientation = Some(quaternion(&e.base_pose.rotation));
        m.base_linear_velocity = Some(to_message(&e.base_linear_velocity));
        m.base_angular_velocity = Some(to_message(&e.base_angular_velocity));
        m.q.clone_from(&e.q);
        m.qd.clone_from(&e.qd);
        m.load.clone_from(&e.load);
        m.orientation = Some(quaternion(&e.orientation));
        m.angular_velocity = Some(to_message(&e.angular_velocity));
        m.specific_force = Some(to_message(&e.specific_force));
        m.soles.clear();
        m.soles.extend(e.soles.iter().map(|(f, n)| Wrench { force: Some(to_message(f)), moment: Some(to_message(n)) }));
        m.static_soles.clone_from(&e.static_soles);
        output.send(channel, time, m)
    }
}
