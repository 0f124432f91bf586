//! Poses of the links of objects as time series, from `/objects`. Logs of earlier versions have them in the frames
//! `object/NAME` of `/tf` only.

use crate::log::messages::Objects;
use crate::log::read::log_error::LogDamage;
use crate::log::read::message_values::pose;
use foxglove::messages::{FrameTransform, FrameTransforms};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use prost::Message as _;

/// What frames of objects begin with.
const PREFIX: &str = "object/";

/// A link of an object; of its root the name is that of the object, of others `OBJECT/LINK`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectSeries {
    /// Its name.
    pub name: String,
    /// Origin of its frame, m.
    pub position: Vec<Vector3<f64>>,
    /// Orientation of its frame.
    pub orientation: Vec<UnitQuaternion<f64>>,
}

/// The series while a log is read.
#[derive(Default)]
pub(super) struct ObjectFrames {
    series: Vec<ObjectSeries>,
    ticks: usize,
    /// The first message has no objects.
    has_none: bool,
    /// Objects differ between ticks.
    has_changed: bool,
    /// They have a topic of their own.
    is_named: bool,
}

impl ObjectFrames {
    /// Objects of the topic `/objects`.
    pub fn named(names: Vec<String>) -> Self {
        let series = names.into_iter().map(|name| ObjectSeries { name, ..Default::default() }).collect();
        ObjectFrames { series, is_named: true, ..Default::default() }
    }

    /// Reads a message of `/objects`.
    pub fn decode(&mut self, data: &[u8]) -> Result<(), prost::DecodeError> {
        let poses = Objects::decode(data)?.poses;
        self.ticks += 1;
        self.has_changed |= poses.len() != 7 * self.series.len();
        for (series, pose) in self.series.iter_mut().zip(poses.chunks_exact(7)) {
            series.position.push(Vector3::new(pose[0], pose[1], pose[2]));
            let orientation = Quaternion::new(pose[3], pose[4], pose[5], pose[6]);
            series.orientation.push(UnitQuaternion::new_unchecked(orientation));
        }
        Ok(())
    }

    /// Reads a message of `/tf`.
    pub fn decode_frames(&mut self, data: &[u8]) -> Result<(), prost::DecodeError> {
        if self.has_none || self.is_named {
            return Ok(());
        }
        let message = FrameTransforms::decode(data)?;
        let objects = || message.transforms.iter().filter_map(|t| Some((t.child_frame_id.strip_prefix(PREFIX)?, t)));
        if self.ticks == 0 {
            let series = |(name, _): (&str, &FrameTransform)| ObjectSeries { name: name.into(), ..Default::default() };
            self.series = objects().map(series).collect();
            self.has_none = self.series.is_empty();
        }
        self.ticks += 1;
        self.has_changed |= !objects().map(|(name, _)| name).eq(self.series.iter().map(|series| series.name.as_str()));
        for (series, (_, transform)) in self.series.iter_mut().zip(objects()) {
            let pose = pose(transform);
            series.position.push(pose.translation.vector);
            series.orientation.push(pose.rotation);
        }
        Ok(())
    }

    /// Number of ticks, if there are objects.
    pub fn ticks(&self) -> Option<usize> {
        (!self.series.is_empty()).then_some(self.ticks)
    }

    /// Keeps the first ticks.
    pub fn truncate(&mut self, ticks: usize) {
        self.ticks = self.ticks.min(ticks);
        for series in &mut self.series {
            series.position.truncate(ticks);
            series.orientation.truncate(ticks);
        }
    }

    /// Checks that there are as many ticks as `times` of other topics, and the same objects at each.
    pub fn check(&self, times: &[f64]) -> Result<(), LogDamage> {
        match self.ticks() {
            Some(_) if self.has_changed => Err(LogDamage::Objects),
            Some(found) if found != times.len() => {
                let topic = if self.is_named { "/objects" } else { "/tf" };
                Err(LogDamage::Ticks { topic, found, expected: times.len() })
            }
            _ => Ok(()),
        }
    }

    /// The series.
    pub fn into_series(self) -> Vec<ObjectSeries> {
        self.series
    }
}
