//! Who else takes what a log holds, while it is made.

use std::collections::BTreeMap;

/// What a topic of the log is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its name.
    pub topic: String,
    /// How its messages are encoded, such as `protobuf`.
    pub encoding: String,
    /// The type of its messages.
    pub schema_name: String,
    /// How the type is described, such as `ros2msg`.
    pub schema_encoding: String,
    /// The description.
    pub schema: Vec<u8>,
    /// What else there is to know of it.
    pub metadata: BTreeMap<String, String>,
}

/// Takes the messages of a log beside its file, or instead of one. It is called by the thread that simulates, so it must not wait
/// for anybody; what it cannot take, it leaves.
pub trait Outlet: Send {
    /// A topic; the number is what its messages come with. A robot's description comes before [`described`](Self::described), and
    /// so do most topics, but one that depends on what a run knows may come with its first message.
    fn channel(&mut self, channel: &ChannelInfo) -> u32;
    /// What came up to here holds for the whole run; whoever comes later must be told of it too.
    fn described(&mut self);
    /// Does anybody listen to anything? If not, nothing is encoded.
    fn is_wanted(&self) -> bool;
    /// Does anybody listen to this topic?
    fn wants(&self, channel: u32) -> bool;
    /// A message at `time`, ns of simulated time.
    fn message(&mut self, channel: u32, time: u64, bytes: &[u8]);
    /// All of an instant is there.
    fn instant(&mut self, time: u64);
}
