//! The parts of a log that a bag contains, and their instants.

use crate::export::export_error::ExportError;
use crate::export::selection::Selection;
use crate::files::confined;
use crate::log::{LogError, MarkerSeries, Scene, Trajectory, nanoseconds};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A log, read for a bag.
#[derive(Clone, Debug, PartialEq)]
pub struct BagLog {
    /// The series.
    pub trajectory: Trajectory,
    /// Frames over time, and the shapes fixed to them.
    pub(super) scene: Scene,
    /// Markers of contacts and forces.
    pub(super) markers: MarkerSeries,
}

/// An instant of the log, with the entries of each series that belong to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BagInstant {
    /// Simulated time, ns.
    pub time: u64,
    /// Index in `trajectory.times`.
    pub tick: Option<usize>,
    /// Index in `scene.times`.
    pub frames: Option<usize>,
    /// Index in `markers.times`.
    pub markers: Option<usize>,
}

impl BagLog {
    /// Reads a log from memory; errors name it `path`.
    ///
    /// # Errors
    /// As [`Trajectory::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        Ok(Self {
            trajectory: Trajectory::from_bytes(path, bytes)?,
            scene: Scene::from_bytes(path, bytes)?,
            markers: MarkerSeries::from_bytes(path, bytes)?,
        })
    }

    /// `SCENARIO_KEY`, the folder of a bag for which the user names none; absent if the log's names
    /// are no name of a folder.
    pub fn default_folder(&self) -> Option<PathBuf> {
        let name = format!("{}_{}", self.trajectory.info.scenario, self.trajectory.info.key);
        confined::is_plain(&name).then(|| name.into())
    }

    /// The instants between the limits of the selection, in order; at least one.
    pub(super) fn instants(&self, selection: &Selection) -> Result<Vec<BagInstant>, ExportError> {
        let mut all: BTreeMap<u64, BagInstant> = BTreeMap::new();
        let mut at = |time: u64, index: usize, set: fn(&mut BagInstant, usize)| {
            set(all.entry(time).or_insert(BagInstant { time, ..Default::default() }), index);
        };
        let ticks = self.trajectory.times.iter().map(|time| nanoseconds(*time));
        ticks.enumerate().for_each(|(i, time)| at(time, i, |instant, i| instant.tick = Some(i)));
        let frames = self.scene.times.iter();
        frames.enumerate().for_each(|(i, time)| at(*time, i, |instant, i| instant.frames = Some(i)));
        let markers = self.markers.times.iter();
        markers.enumerate().for_each(|(i, time)| at(*time, i, |instant, i| instant.markers = Some(i)));
        let (Some((first, _)), Some((last, _))) = (all.first_key_value(), all.last_key_value()) else {
            return Err(ExportError::NoTopics);
        };
        let (first, last) = (*first, *last);
        // Negative times are those before the log.
        let from = selection.from.map_or(0, nanoseconds);
        let to = selection.to.filter(|to| *to >= 0.0).map(nanoseconds);
        let to = if selection.to.is_some() { to } else { Some(u64::MAX) };
        let inside = |instant: &BagInstant| instant.time >= from && to.is_some_and(|to| instant.time <= to);
        let chosen: Vec<BagInstant> = all.into_values().filter(inside).collect();
        if chosen.is_empty() {
            let seconds = |time: u64| time as f64 / 1e9;
            let (first, last) = (seconds(first), seconds(last));
            let (from, to) = (selection.from.unwrap_or(first), selection.to.unwrap_or(last));
            return Err(ExportError::NoInstants { from, to, first, last });
        }
        Ok(chosen)
    }
}
