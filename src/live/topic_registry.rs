//! Registry of topics: what a client receives when it connects or subscribes.

use std::sync::Arc;

use crate::log::ChannelInfo;

/// All topics of this and earlier runs; a topic's index is its channel number.
#[derive(Clone, Default)]
pub(super) struct TopicRegistry {
    pub channels: Vec<TopicEntry>,
}

/// A topic.
#[derive(Clone)]
pub(super) struct TopicEntry {
    pub info: Arc<ChannelInfo>,
    /// True if the present run has it.
    pub is_open: bool,
    /// Messages that are valid for the whole run, such as the robot's description, with their
    /// times, ns.
    pub retained: Arc<Vec<(u64, Vec<u8>)>>,
}

impl TopicRegistry {
    /// Closes all topics; a new run opens its own.
    pub fn begin(&mut self) {
        self.channels.iter_mut().for_each(|entry| entry.is_open = false);
    }

    /// Opens a topic for the present run and returns its number. An equal earlier topic keeps its
    /// number, so that clients stay subscribed.
    pub fn open(&mut self, info: &ChannelInfo) -> u32 {
        let found = self.channels.iter().position(|entry| *entry.info == *info);
        let index = found.unwrap_or(self.channels.len());
        if found.is_none() {
            self.channels.push(TopicEntry { info: Arc::new(info.clone()), is_open: true, retained: Arc::default() });
        }
        let entry = &mut self.channels[index];
        entry.is_open = true;
        entry.retained = Arc::default();
        u32::try_from(index).unwrap_or(u32::MAX)
    }

    /// Retains a message for later subscribers.
    pub fn retain(&mut self, channel: u32, time: u64, bytes: &[u8]) {
        if let Some(entry) = self.channels.get_mut(channel as usize) {
            Arc::make_mut(&mut entry.retained).push((time, bytes.to_vec()));
        }
    }
}
