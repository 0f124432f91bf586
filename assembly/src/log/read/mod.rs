//! Reads a `log.mcap` back: its topics of our own messages as a [`Trajectory`], its frames and
//! shapes as a [`Scene`].
//!
//! The file is read whole and verified first. Topics that repeat the same data for viewers (ROS 2,
//! markers) are skipped.

mod estimate_series;
mod log_error;
mod log_file;
mod marker_series;
mod message_values;
mod object_series;
mod scene;
mod self_collision_series;
mod trajectory;
mod trajectory_reader;

pub use estimate_series::{EstimateSeries, JointReadings, SoleReadings};
pub use log_error::{LogDamage, LogError};
pub use log_file::read_bytes;
pub(super) use log_file::{LogFile, MAX_GROWTH, MAX_RECORD, RUN_ENTRIES};
pub use marker_series::MarkerSeries;
pub use object_series::ObjectSeries;
pub use scene::{Frame, Scene};
pub use self_collision_series::SelfCollisionSeries;
pub use trajectory::{
    Attachment, ContactPoint, JointSeries, LoggedEvent, Motion, PointSeries, RunInfo, SoleSeries, Trajectory,
    VertexSeries,
};
