//! The drawn part of a log: frames over time and the shapes attached to them.

use crate::log::read::log_error::{LogDamage, LogError};
use crate::log::read::log_file::LogFile;
use crate::log::read::message_values::pose;
use foxglove::messages::{FrameTransform, FrameTransforms, SceneEntity, SceneUpdate};
use nalgebra::Isometry3;
use prost::Message as _;
use std::path::Path;

/// The topics `/tf` and `/scene`. Empty where the scenario did not log `scene`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Log times of the ticks, ns.
    pub times: Vec<u64>,
    /// Every frame but that of the world, in the log's order.
    pub frames: Vec<Frame>,
    /// Shapes of robot and floor, each in the frame it names.
    pub entities: Vec<SceneEntity>,
}

/// A frame and its poses in its parent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Its name: of a link, or `sole/NAME`.
    pub name: String,
    /// Its parent frame.
    pub parent: String,
    /// One pose per tick, m.
    pub poses: Vec<Isometry3<f64>>,
}

impl Scene {
    /// Reads these topics of a log; errors name it `path`.
    ///
    /// # Errors
    /// As [`Trajectory::read`](crate::log::Trajectory::read).
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        let file = LogFile::open(path, bytes)?;
        let mut scene = Self::default();
        for message in file.messages()? {
            let message = message?;
            let malformed = |source| file.damage(LogDamage::Message { topic: message.channel.topic.clone(), source });
            match message.channel.topic.as_str() {
                "/tf" => {
                    let update = FrameTransforms::decode(&*message.data).map_err(malformed)?;
                    scene.tick(message.log_time, update.transforms).map_err(|damage| file.damage(damage))?;
                }
                "/scene" => {
                    let update = SceneUpdate::decode(&*message.data).map_err(malformed)?;
                    scene.entities.extend(update.entities);
                }
                _ => {}
            }
        }
        Ok(scene)
    }

    fn tick(&mut self, time: u64, transforms: Vec<FrameTransform>) -> Result<(), LogDamage> {
        if self.times.is_empty() {
            let frame = |t: &FrameTransform| Frame {
                name: t.child_frame_id.clone(),
                parent: t.parent_frame_id.clone(),
                poses: Vec::new(),
            };
            self.frames = transforms.iter().map(frame).collect();
        }
        let same = |(f, t): (&Frame, &FrameTransform)| f.name == t.child_frame_id && f.parent == t.parent_frame_id;
        if self.frames.len() != transforms.len() || !self.frames.iter().zip(&transforms).all(same) {
            return Err(LogDamage::Frames(time));
        }
        self.times.push(time);
        for (frame, transform) in self.frames.iter_mut().zip(&transforms) {
            frame.poses.push(pose(transform));
        }
        Ok(())
    }
}
