//! The markers of a log over time: contacts, forces and points of balance, as drawn by viewers.

use crate::log::read::log_error::{LogDamage, LogError};
use crate::log::read::log_file::LogFile;
use foxglove::messages::{SceneEntity, SceneUpdate};
use prost::Message as _;
use std::path::Path;

/// The topic `/scene/contact`. Empty where the scenario did not log `scene`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkerSeries {
    /// Log times of the messages, ns.
    pub times: Vec<u64>,
    /// The entities of each message. They replace those of the message before.
    pub entities: Vec<Vec<SceneEntity>>,
}

impl MarkerSeries {
    /// Reads the markers of a log; errors name it `path`.
    ///
    /// # Errors
    /// As [`Trajectory::read`](crate::log::Trajectory::read).
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        let file = LogFile::open(path, bytes)?;
        let mut series = Self::default();
        for message in file.messages()? {
            let message = message?;
            if message.channel.topic != "/scene/contact" {
                continue;
            }
            let update = SceneUpdate::decode(&*message.data)
                .map_err(|source| file.damage(LogDamage::Message { topic: message.channel.topic.clone(), source }))?;
            series.times.push(message.log_time);
            series.entities.push(update.entities);
        }
        Ok(series)
    }
}
