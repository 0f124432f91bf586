//! Writes `/state`, the motion of the whole robot, and the same joints as ROS 2 messages on
//! `/joint_states`, with `/robot_description`.

use crate::files::RecordError;
use crate::log::messages::{Force, Quaternion, State};
use crate::log::ros;
use crate::log::write::conversion::{to_message, to_messages};
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::{JointKind, Model};
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct StateTopic {
    channel: Channel,
    message: State,
}

impl StateTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let names: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let kinds: Vec<&str> = model.joints.iter().map(|j| kind(j.kind)).collect();
        let list = |names: &[&str]| serde_json::json!(names).to_string();
        let metadata = BTreeMap::from([("joints".to_owned(), list(&names)), ("joint_kinds".to_owned(), list(&kinds))]);
        Ok(Self { channel: output.stiction("/state", "State", metadata)?, message: State::default() })
    }
}

/// The URDF's name of a kind of joint; it determines the unit of the joint's values.
fn kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
    }
}

impl Topic for StateTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let m = &mut self.message;
        let r = &s.base_pose.rotation;
        m.time = s.time;
        m.base_position = Some(to_message(&s.base_pose.translation.vector));
        m.base_orientation = Some(Quaternion { w: r.w, x: r.i, y: r.j, z: r.k });
        m.base_linear_velocity = Some(to_message(&s.base_linear_velocity));
        m.base_angular_velocity = Some(to_message(&s.base_angular_velocity));
        m.q.clone_from(&s.q);
        m.qd.clone_from(&s.qd);
        m.q_desired.clone_from(&s.q_desired);
        m.qd_desired.clone_from(&s.qd_desired);
        m.effort.clone_from(&s.effort);
        m.effort_desired.clone_from(&s.effort_desired);
        m.com = Some(to_message(&s.com));
        m.com_velocity = Some(to_message(&s.com_velocity));
        m.cop = s.centre_of_pressure.as_ref().map(to_message);
        m.stable_point = s.stable_point.as_ref().map(to_message);
        to_messages(&s.support_polygon, &mut m.support_polygon);
        // The points are mostly the same as at the last tick, so their names keep their storage.
        m.points.resize_with(s.points.len(), Default::default);
        for (to, from) in m.points.iter_mut().zip(&s.points) {
            to.name.clone_from(&from.name);
            to.position = from.position.as_ref().map(to_message);
        }
        m.external.clear();
        m.external
            .extend(s.external.iter().map(|(p, f)| Force { point: Some(to_message(p)), force: Some(to_message(f)) }));
        output.send(&mut self.channel, time, m)
    }
}

pub(super) struct JointStateTopic {
    channel: Channel,
    message: ros::JointState,
}

impl JointStateTopic {
    /// Opens the topic and writes the robot's description, once.
    pub fn open(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        let mut description = output.ros("/robot_description", "std_msgs/msg/String", ros::STRING)?;
        output.send_cdr(&mut description, 0, &ros::Text { data: header.urdf.text.to_owned() })?;
        Ok(Self {
            channel: output.ros("/joint_states", "sensor_msgs/msg/JointState", ros::JOINT_STATE)?,
            message: ros::JointState {
                header: ros::Header { stamp: ros::Time::from_nanoseconds(0), frame_id: String::new() },
                name: model.joints.iter().map(|j| j.name.clone()).collect(),
                position: Vec::new(),
                velocity: Vec::new(),
                effort: Vec::new(),
            },
        })
    }
}

impl Topic for JointStateTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let m = &mut self.message;
        m.header.stamp = ros::Time::from_nanoseconds(time);
        m.position.clone_from(&s.q);
        m.velocity.clone_from(&s.qd);
        m.effort.clone_from(&s.effort);
        output.send_cdr(&mut self.channel, time, m)
    }
}
