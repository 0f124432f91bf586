//! Selected instant of a recording.

use crate::log::Trajectory;

/// Selected instant of the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cursor {
    /// Selected time or time of the selected event, s.
    pub time: f64,
    /// Index of the displayed log instant: the last one not after `time`.
    pub tick: usize,
}

impl Cursor {
    pub fn at(log: &Trajectory, time: f64) -> Self {
        let after = log.times.partition_point(|t| *t <= time + 1e-9);
        Cursor { time, tick: after.saturating_sub(1) }
    }
}
