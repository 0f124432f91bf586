//! The drawn part of a run, from the topics of its log.

use crate::log::{Scene, Trajectory, read_bytes};
use crate::view::view_error::ViewError;
use std::path::Path;

/// A log prepared for drawing: the ticks at which the robot's frames are known, and the other
/// series at these ticks.
#[derive(Clone, Debug)]
pub struct DrawnRun {
    /// The run's series. `motion` and `soles` are `None` where the scenario did not log them.
    pub run: Trajectory,
    /// Frames and shapes.
    pub scene: Scene,
    /// Simulated times of the ticks, s.
    pub times: Vec<f64>,
    /// Index of each tick in the series of `run`.
    pub rows: Vec<usize>,
}

impl DrawnRun {
    /// Reads a log.
    ///
    /// # Errors
    /// It cannot be read, is damaged, or has no frames.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        let bytes = read_bytes(path)?;
        let run = Trajectory::from_bytes(path, &bytes)?;
        let scene = Scene::from_bytes(path, &bytes)?;
        Self::new(run, scene).ok_or_else(|| ViewError::NoScene { path: path.to_owned() })
    }

    /// Keeps the ticks that both parts have; `None` if there are no frames at any tick.
    fn new(run: Trajectory, mut scene: Scene) -> Option<Self> {
        // Frames have only the log time, to the nanosecond.
        let nanoseconds = |time: f64| (time * 1e9).round() as u64;
        let row = |ns: u64| run.times.binary_search_by_key(&ns, |time| nanoseconds(*time)).ok();
        let rows: Vec<usize> = if run.times.is_empty() {
            (0..scene.times.len()).collect()
        } else {
            // A failed run may have written its last tick on some topics only.
            scene.times.iter().map_while(|ns| row(*ns)).collect()
        };
        scene.times.truncate(rows.len());
        scene.frames.iter_mut().for_each(|frame| frame.poses.truncate(rows.len()));
        let time = |(ns, row): (&u64, &usize)| run.times.get(*row).copied().unwrap_or(*ns as f64 * 1e-9);
        let times: Vec<f64> = scene.times.iter().zip(&rows).map(time).collect();
        (!times.is_empty()).then_some(Self { run, scene, times, rows })
    }

    /// Name of the root frame, the one without parent.
    pub fn world(&self) -> &str {
        let frames = &self.scene.frames;
        let root = frames.iter().find(|f| !frames.iter().any(|other| other.name == f.parent));
        root.map_or("world", |f| f.parent.as_str())
    }

    /// Indices of the ticks to show, at most `rate` per second: the first, further ones at least
    /// 0.99 periods apart (logged times are rounded), and the last.
    pub fn thinned(&self, rate: Option<f64>) -> Vec<usize> {
        let Some(rate) = rate else { return (0..self.times.len()).collect() };
        let period = 0.99 / rate;
        let mut ticks: Vec<usize> = Vec::new();
        for (i, time) in self.times.iter().enumerate() {
            if ticks.last().is_none_or(|&last| time - self.times[last] >= period) {
                ticks.push(i);
            }
        }
        let last = self.times.len() - 1;
        if ticks.last() != Some(&last) {
            ticks.push(last);
        }
        ticks
    }
}
