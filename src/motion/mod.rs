//! Joint motions: the files that hold them and the curves through them.
//!
//! A [`Motion`] is what a file says: for each name a list of times and values that know where they were written.
//! [`postures`] and [`columns`] read the files of `playback`, [`bvh`] those of motion capture; [`spline`] joins knots by
//! curves of least jerk, [`limit`] keeps a stream within a range and a speed. Nothing here knows a robot.

pub mod bvh;
pub mod columns;
pub mod limit;
pub mod minimum_jerk;
pub mod postures;
pub mod spline;

use std::ops::Range;

/// What a file says about how things move.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Motion {
    /// One for each joint or channel, in the order in which the file first names them.
    pub tracks: Vec<Track>,
}

/// One joint or channel.
#[derive(Clone, PartialEq, Debug)]
pub struct Track {
    /// Its name.
    pub name: String,
    /// Where the file names it first, bytes.
    pub place: Range<usize>,
    /// Values in order of time, at least one; times rise.
    pub knots: Vec<Knot>,
}

/// A value at a time.
#[derive(Clone, PartialEq, Debug)]
pub struct Knot {
    /// s.
    pub time: f64,
    /// rad, m, or the file's own unit where it says so.
    pub value: f64,
    /// Where it stands, bytes.
    pub place: Range<usize>,
}

/// What is wrong with a file, and where.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct Fault {
    /// Bytes of the text.
    pub place: Range<usize>,
    /// What was seen and what is wanted.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Fault {
    fn new(place: Range<usize>, message: impl Into<String>) -> Self {
        Fault { place, message: message.into(), help: None }
    }

    fn help(self, help: impl Into<String>) -> Self {
        Fault { help: Some(help.into()), ..self }
    }
}

impl Motion {
    /// The track of that name.
    pub fn track(&self, name: &str) -> Option<&Track> {
        self.tracks.iter().find(|t| t.name == name)
    }

    /// Times of the first and the last value of all; none when there is none.
    pub fn span(&self) -> Option<(f64, f64)> {
        let times = || self.tracks.iter().flat_map(|t| &t.knots).map(|k| k.time);
        Some((times().min_by(f64::total_cmp)?, times().max_by(f64::total_cmp)?))
    }
}
