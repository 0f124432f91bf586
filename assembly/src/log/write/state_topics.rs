//! Writes `/state`, the motion of the whole robot, and the same joints as ROS 2 messages on
//! `/joint_states`, with `/robot_description`.

use crate::files::RecordError;
use crate::log::ros;
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::proto_writer::extend_with_doubles;
use crate::log::write::topic::Topic;
use crate::robot::{JointKind, Model};
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct StateTopic(Channel);

impl StateTopic {
    pub fn open(output: &mut LogOutput, model: &Model) -> Result<Self, RecordError> {
        let names: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let kinds: Vec<&str> = model.joints.iter().map(|j| kind(j.kind)).collect();
        let list = |names: &[&str]| serde_json::json!(names).to_string();
        let metadata = BTreeMap::from([("joints".to_owned(), list(&names)), ("joint_kinds".to_owned(), list(&kinds))]);
        Ok(Self(output.stiction("/state", "State", metadata)?))
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
    /// Fields as in [`State`](crate::log::messages::State).
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        output.send_fields(&mut self.0, time, |to| {
            to.double(1, s.time);
            to.vector(2, &s.base_pose.translation.vector);
            to.quaternion(3, &s.base_pose.rotation);
            to.vector(4, &s.base_linear_velocity);
            to.vector(5, &s.base_angular_velocity);
            to.doubles(6, &s.q);
            to.doubles(7, &s.qd);
            to.doubles(8, &s.q_desired);
            to.doubles(9, &s.qd_desired);
            to.doubles(10, &s.effort);
            to.vector(11, &s.com);
            to.vector(12, &s.com_velocity);
            s.centre_of_pressure.iter().for_each(|p| to.vector(13, p));
            to.vectors(14, &s.support_polygon);
            for (point, force) in &s.external {
                to.message(15, |to| {
                    to.vector(1, point);
                    to.vector(2, force);
                });
            }
            s.stable_point.iter().for_each(|p| to.vector(16, p));
            to.doubles(17, &s.effort_desired);
            for point in &s.points {
                to.message(18, |to| {
                    to.text(1, &point.name);
                    point.position.iter().for_each(|p| to.vector(2, p));
                });
            }
        })
    }
}

pub(super) struct JointStateTopic {
    channel: Channel,
    /// The message; its lists begin after `names` bytes.
    message: Vec<u8>,
    names: usize,
}

/// Bytes before the content of a CDR message; alignment counts from their end.
const ENCAPSULATION: usize = 4;

impl JointStateTopic {
    /// Opens the topic and writes the robot's description, once.
    pub fn open(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        let mut description = output.ros("/robot_description", "std_msgs/msg/String", ros::STRING)?;
        output.send_cdr(&mut description, 0, &ros::Text { data: header.urdf.text.to_owned() })?;
        let names: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let start = ros::Header { stamp: ros::Time::from_nanoseconds(0), frame_id: String::new() };
        let message = cdr::serialize::<_, _, cdr::CdrLe>(&(start, names), cdr::Infinite)
            .map_err(|e| RecordError::Encode { topic: "/joint_states", reason: e.to_string() })?;
        Ok(Self {
            channel: output.ros("/joint_states", "sensor_msgs/msg/JointState", ros::JOINT_STATE)?,
            names: message.len(),
            message,
        })
    }

    /// Appends a list of numbers: its length, aligned to 4 bytes, and the numbers, aligned to 8.
    fn append(&mut self, list: &[f64]) {
        let m = &mut self.message;
        let align =
            |m: &mut Vec<u8>, to: usize| m.resize((m.len() - ENCAPSULATION).next_multiple_of(to) + ENCAPSULATION, 0);
        align(m, 4);
        m.extend_from_slice(&(list.len() as u32).to_le_bytes());
        if !list.is_empty() {
            align(m, 8);
            extend_with_doubles(m, list);
        }
    }
}

impl Topic for JointStateTopic {
    /// Fields as in [`JointState`](ros::JointState).
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let stamp = ros::Time::from_nanoseconds(time);
        self.message.truncate(self.names);
        self.message[ENCAPSULATION..ENCAPSULATION + 4].copy_from_slice(&stamp.sec.to_le_bytes());
        self.message[ENCAPSULATION + 4..ENCAPSULATION + 8].copy_from_slice(&stamp.nanosec.to_le_bytes());
        [&s.q, &s.qd, &s.effort].into_iter().for_each(|list| self.append(list));
        output.send_bytes(&mut self.channel, time, &self.message)
    }
}
