//! Poses of the links of objects as time series, from the frames `object/NAME` of `/tf`.

use crate::log::read::log_error::LogDamage;
use crate::log::read::message_values::pose;
use foxglove::messages::{FrameTransform, FrameTransforms};
use nalgebra::{UnitQuaternion, Vector3};
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
}

impl ObjectFrames {
    /// Reads a message of `/tf`.
    pub fn decode(&mut self, data: &[u8]) -> Result<(), prost::DecodeError> {
        if self.has_none {
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
            Some(found) if found != times.len() => Err(LogDamage::Ticks { topic: "/tf", found, expected: times.len() }),
            Some(_) if self.has_changed => Err(LogDamage::Objects),
            _ => Ok(()),
        }
    }

    /// The series.
    pub fn into_series(self) -> Vec<ObjectSeries> {
        self.series
    }
}
