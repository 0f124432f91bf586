//! Writes `/loops`: forces and errors of closed loops and couplings.

use crate::files::RecordError;
use crate::log::messages::{Loops, Vector3};
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::Model;
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct LoopsTopic {
    channel: Channel,
    message: Loops,
}

impl LoopsTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let loops: Vec<&str> = model.loops.iter().map(|closure| closure.name.as_str()).collect();
        let joint = |coupling: &crate::robot::Coupling| model.joints[coupling.joint.0].name.as_str();
        let couplings: Vec<&str> = model.couplings.iter().map(joint).collect();
        let text = |names: Vec<&str>| serde_json::json!(names).to_string();
        let metadata = BTreeMap::from([("loops".to_owned(), text(loops)), ("couplings".to_owned(), text(couplings))]);
        Ok(Self { channel: output.stiction("/loops", "Loops", metadata)?, message: Loops::default() })
    }
}

fn vector(v: &nalgebra::Vector3<f64>) -> Vector3 {
    Vector3 { x: v.x, y: v.y, z: v.z }
}

impl Topic for LoopsTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let m = &mut self.message;
        m.time = s.time;
        for list in [&mut m.errors, &mut m.coupling_efforts, &mut m.coupling_errors] {
            list.clear();
        }
        m.forces.clear();
        m.moments.clear();
        for ([force, moment], error) in &s.loops {
            m.forces.push(vector(force));
            m.moments.push(vector(moment));
            m.errors.push(*error);
        }
        m.coupling_efforts.extend(s.couplings.iter().map(|(effort, _)| effort));
        m.coupling_errors.extend(s.couplings.iter().map(|(_, error)| error));
        output.send(&mut self.channel, time, &self.message)
    }
}
