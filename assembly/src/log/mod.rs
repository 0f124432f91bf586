//! The log of a run, `log.mcap`: the topics written at every tick, and the reader that turns a log
//! into time series.
//!
//! - [`messages`], [`ros`], `message_descriptor`: the message types and their description to
//!   foreign readers.
//! - `write`: [`LogWriter`], an [`Observer`](crate::sim::Observer) of one run, and its topics.
//! - `read`: [`Trajectory`] and [`Scene`], a log as series and as shapes.
//! - [`salvage()`]: recovers the readable part of a damaged or unfinished log.
//! - [`ProblemWriter`]: the contact problems of a run, `problems/*.json`.
//!
//! Imports: `math`, `input`, `robot`, `terrain`, `contact`, `sim`, `files`, `convert`. Used by:
//! `assemble`, `report`, `export`, `live`, `batch`, `replay`, `view`, `cli`, `console`, `fit`.

mod message_descriptor;
pub mod messages;
mod problem_files;
mod read;
pub mod ros;
mod salvage;
mod topic_groups;
mod write;

pub use problem_files::{MAX_PROBLEMS, PROBLEM_SCHEMA, ProblemRecord, ProblemWriter};
pub use read::{Attachment, JointSeries, LogDamage, LogError, LoggedEvent, Motion, PointSeries, RunInfo};
pub use read::{ContactPoint, SoleSeries, Trajectory, VertexSeries, read_bytes};
pub use read::{EstimateSeries, Frame, JointReadings, MarkerSeries, ObjectSeries, Scene};
pub use read::{SelfCollisionSeries, SoleReadings};
pub use salvage::{SalvageError, Salvaged, salvage};
pub use topic_groups::{ParseTopicError, TopicGroups};
pub use write::{AttachedText, ChannelInfo, LogHeader, LogWriter, MessageSink};
pub use write::{nanoseconds, object_frame, sole_frame, welds};
