//! Joint motions: motion files and the curves through their values.
//!
//! A [`Motion`] is the content of a file: for each name, times and values with their spans in the
//! text. [`postures`] and [`columns`] read the files of `playback`, [`bvh`] those of motion
//! capture. [`spline`] joins knots by minimum-jerk curves, [`minimum_jerk`] changes parameters
//! smoothly, [`limit`] limits a stream in range and speed.
//!
//! Independent of robots.
//!
//! Imports: `math`, `text`. Used by: `collision`, `task`, `force`, `assemble`.

pub mod bvh;
pub mod columns;
pub mod limit;
pub mod minimum_jerk;
pub mod postures;
pub mod spline;

use std::ops::Range;

/// The content of a motion file.
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
    /// Span of its first mention in the file, bytes.
    pub span: Range<usize>,
    /// Values in order of time, at least one; times increase.
    pub knots: Vec<Knot>,
}

/// A value at a time.
#[derive(Clone, PartialEq, Debug)]
pub struct Knot {
    /// s.
    pub time: f64,
    /// rad, m, or the file's own unit where its reader says so.
    pub value: f64,
    /// Span in the file, bytes.
    pub span: Range<usize>,
}

/// An error in a motion file, with its span.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{message}")]
pub struct MotionError {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What was found and what was expected.
    pub message: String,
    /// How to fix it.
    pub help: Option<String>,
}

impl MotionError {
    fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        MotionError { span, message: message.into(), help: None }
    }

    fn help(self, help: impl Into<String>) -> Self {
        MotionError { help: Some(help.into()), ..self }
    }
}

impl Motion {
    /// The track of that name.
    pub fn track(&self, name: &str) -> Option<&Track> {
        self.tracks.iter().find(|t| t.name == name)
    }

    /// Times of the first and the last value of all tracks; none without values.
    pub fn span(&self) -> Option<(f64, f64)> {
        let times = || self.tracks.iter().flat_map(|t| &t.knots).map(|k| k.time);
        Some((times().min_by(f64::total_cmp)?, times().max_by(f64::total_cmp)?))
    }
}
