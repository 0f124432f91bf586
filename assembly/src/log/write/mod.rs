//! Writes a log: the fixed part first, then one message per topic and tick.
//!
//! A log serves viewers and programs. Each viewer finds what it draws: frames and scene in
//! Foxglove's protobuf messages, joint states and robot description in ROS 2's CDR, and the tick
//! record in packed protobuf messages of our own. The file describes all of them. The log time is
//! the simulated time in nanoseconds; no clock, host name or random number enters, so equal runs
//! give equal bytes.
//!
//! A new topic is a file with a type that implements `Topic`, and a line in `open_topics` of
//! `log_writer.rs`.

mod contact_topic;
mod conversion;
mod estimate_topic;
mod event_topics;
mod frames_topic;
mod log_header;
mod log_output;
mod log_writer;
mod loops_topic;
mod marker_topic;
mod message_sink;
mod objects_topic;
mod proto_writer;
mod residual_topic;
mod scene_shapes;
mod self_collision_topic;
mod state_topics;
mod topic;

pub use conversion::nanoseconds;
pub use frames_topic::{object_frame, sole_frame, welds};
pub use log_header::{AttachedText, LogHeader};
pub(in crate::log) use log_output::log_options;
pub use log_writer::LogWriter;
pub use message_sink::{ChannelInfo, MessageSink};
