//! The interface of a receiver of log messages while the run is simulated.

use std::collections::BTreeMap;

/// Description of a topic of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its name.
    pub topic: String,
    /// Encoding of its messages, such as `protobuf`.
    pub encoding: String,
    /// Type of its messages.
    pub schema_name: String,
    /// Encoding of the type's description, such as `ros2msg`.
    pub schema_encoding: String,
    /// The type's description.
    pub schema: Vec<u8>,
    /// Metadata, such as the names of joints.
    pub metadata: BTreeMap<String, String>,
}

/// Receives the messages of a log in addition to its file, or instead of one.
///
/// The simulating thread calls it, so an implementation must not block; it drops the messages that
/// it cannot take.
pub trait MessageSink: Send {
    /// Opens a topic and returns the number that identifies it in the calls below. The robot's
    /// description and most topics come before [`end_description`](Self::end_description); a topic
    /// that depends on the run opens with its first message.
    fn open_channel(&mut self, channel: &ChannelInfo) -> u32;
    /// Ends the description of the run. Messages up to here are valid for the whole run, so later
    /// subscribers get them too.
    fn end_description(&mut self);
    /// True if any topic has a subscriber. If none has, nothing is encoded.
    fn has_subscribers(&self) -> bool;
    /// True if this topic has a subscriber.
    fn is_subscribed(&self, channel: u32) -> bool;
    /// Receives a message at `time`, ns of simulated time.
    fn message(&mut self, channel: u32, time: u64, bytes: &[u8]);
    /// Ends the messages of a tick.
    fn end_tick(&mut self, time: u64);
}
