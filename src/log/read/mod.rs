//! Reads a `log.mcap` of ours back into time series.
//!
//! A log is read whole: its index says which texts and tables it holds, its messages become a [`Trajectory`]. What is there
//! to be drawn, frames and shapes, becomes a [`Scene`]; topics that say the same again (ROS 2, marks) are passed over.

mod estimate;
mod file;
mod scene;
mod self_contact;
mod series;
mod ticks;

pub use estimate::{EstimateSeries, JointReadings, SoleReadings};
pub use file::LogError;
pub use scene::{Frame, Scene};
pub use self_contact::SelfCollisionSeries;
pub use series::{
    Attachment, JointSeries, LoggedEvent, Motion, PointSeries, RunInfo, SoleSeries, Trajectory, VertexSeries,
};

use crate::files::input;
use file::LogFile;
use std::path::Path;
use ticks::Ticks;

impl Trajectory {
    /// Reads a log.
    ///
    /// # Errors
    /// No such file; a file that is no MCAP or not one of ours; one that was cut short or changed since it was written.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        let bytes = input::read(path, input::UNLIMITED);
        let bytes = bytes.map_err(|source| LogError::Io { path: path.to_owned(), source })?;
        Self::from_bytes(path, &bytes)
    }

    /// The same for a log that is already at hand; `path` is what errors call it.
    ///
    /// # Errors
    /// See [`Trajectory::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        let file = LogFile::open(path, bytes)?;
        let (info, complete, attachments) = (file.info()?, file.is_complete()?, file.attachments()?);
        let ticks = Ticks::read(&file)?;
        Ok(ticks.into_trajectory(info, complete, attachments))
    }
}
