//! What a client is told whenever it comes: the topics, and what holds for the whole run.

use std::sync::Arc;

use crate::log::ChannelInfo;

/// All topics there ever were; their places are their numbers.
#[derive(Clone, Default)]
pub(super) struct Book {
    pub channels: Vec<Entry>,
}

/// A topic.
#[derive(Clone)]
pub(super) struct Entry {
    pub info: Arc<ChannelInfo>,
    /// Does the present run have it?
    pub is_open: bool,
    /// Messages that hold for the whole run, with their times, ns.
    pub kept: Arc<Vec<(u64, Vec<u8>)>>,
}

impl Book {
    /// A new run describes itself.
    pub fn begin(&mut self) {
        self.channels.iter_mut().for_each(|entry| entry.is_open = false);
    }

    /// The number of a topic of the present run. What was the same before keeps its number, so that clients stay subscribed.
    pub fn open(&mut self, info: &ChannelInfo) -> u32 {
        let found = self.channels.iter().position(|entry| *entry.info == *info);
        let place = found.unwrap_or(self.channels.len());
        if found.is_none() {
            self.channels.push(Entry { info: Arc::new(info.clone()), is_open: true, kept: Arc::default() });
        }
        let entry = &mut self.channels[place];
        entry.is_open = true;
        entry.kept = Arc::default();
        u32::try_from(place).unwrap_or(u32::MAX)
    }

    /// Keeps a message for whoever comes later.
    pub fn keep(&mut self, channel: u32, time: u64, bytes: &[u8]) {
        if let Some(entry) = self.channels.get_mut(channel as usize) {
            Arc::make_mut(&mut entry.kept).push((time, bytes.to_vec()));
        }
    }
}
