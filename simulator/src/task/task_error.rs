//! Errors of tasks. Each ends its run with outcome `error`.

use super::kinematic::{NotPlannable, Unreachable};
use std::error::Error;

/// Error of a call of a task.
#[derive(Debug, thiserror::Error)]
pub enum TaskError {
    /// The robot or its drives do not fit the task.
    #[error(transparent)]
    NotPlannable(#[from] NotPlannable),
    /// No joint positions meet the goal.
    #[error(transparent)]
    Unreachable(#[from] Unreachable),
    /// `walk` starts on a tilted sole.
    #[error("the sole `{sole}` is tilted by {angle:.3} rad; `walk` requires level soles")]
    TiltedSole {
        /// Name of the sole.
        sole: String,
        /// Tilt, rad.
        angle: f64,
    },
    /// `walk` starts under tilted gravity.
    #[error("gravity is tilted by {angle:.3} rad from the vertical; `walk` requires vertical gravity")]
    TiltedGravity {
        /// Tilt, rad.
        angle: f64,
    },
    /// The preview control of `walk` has no gains.
    #[error("no gait exists for a centre of mass at {height} m under a gravity of {gravity} m/s^2")]
    NoGait {
        /// Height of the centre of mass above the soles, m.
        height: f64,
        /// Gravity, m/s^2.
        gravity: f64,
    },
    /// An oscillation would leave the range of its joint.
    #[error("the oscillation of `{joint}`, {swing}, leaves its range, {lower:.4} to {upper:.4}")]
    SwingOutOfRange {
        /// The joint.
        joint: String,
        /// Amplitude and centre, rad or m.
        swing: String,
        /// Lower end of the range.
        lower: f64,
        /// Upper end of the range.
        upper: f64,
    },
    /// An error of a task implemented elsewhere, such as a script.
    #[error(transparent)]
    Other(Box<dyn Error + Send + Sync>),
}

impl TaskError {
    /// Wraps an error of a task implemented elsewhere.
    pub fn other(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        TaskError::Other(error.into())
    }
}

/// The first error of a control tick and the task that returned it.
#[derive(Debug, thiserror::Error)]
#[error("task {task}: {error}")]
pub struct TaskFailure {
    /// Name of the task.
    pub task: String,
    /// Its error.
    #[source]
    pub error: TaskError,
}
