//! A sweep given to an engine that runs jobs on many machines: an array of jobs, one for each part, and a job after them that
//! merges. What is the same for every engine is here; each engine has a folder of its own.
//!
//! ```text
//! DIR/part-0, DIR/part-1, ...   the parts, folders of results (docs/scale.md)
//! DIR/results                   what one batch of all runs would have left
//! DIR/submit                    scripts, jobs.json, what the jobs said
//! ```
//!
//! Scripts are read by shells and by engines that have rules of their own for quotes, so every word of them is quoted here;
//! programs are started with their arguments as a list, never through a shell.

mod error;
mod folder;
mod jobs;
pub mod slurm;
mod text;
mod tool;

use std::num::NonZero;
use std::path::{Path, PathBuf};

pub use error::SubmitError;
pub use jobs::{Jobs, SUBMIT_SCHEMA};

/// What is to be shared out.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The program, its absolute path.
    pub runner: PathBuf,
    /// Arguments of `runner run` that all parts share: options and scenarios, these by their absolute paths.
    pub arguments: Vec<String>,
    /// The number of runs of a part side by side; none: as many as the job has processors.
    pub jobs: Option<NonZero<usize>>,
    /// Folder of everything, absolute.
    pub folder: PathBuf,
    /// Number of parts.
    pub parts: NonZero<u64>,
    /// Runs of the whole plan.
    pub runs: usize,
    /// A hash of them, see [`crate::record::PlanHash`].
    pub plan: String,
}

impl Sweep {
    /// Folder of the merged results.
    pub fn results(&self) -> PathBuf {
        self.folder.join("results")
    }

    /// Folder of scripts, `jobs.json` and what the jobs say.
    pub fn scripts(&self) -> PathBuf {
        self.folder.join("submit")
    }

    /// Folder of a part, from 0.
    pub fn part(&self, number: u64) -> PathBuf {
        self.folder.join(format!("part-{number}"))
    }

    /// Is there nothing in the folder that belongs to another plan? What is there of this one is completed.
    ///
    /// # Errors
    /// There is, or it cannot be looked at.
    pub fn check_folder(&self) -> Result<(), SubmitError> {
        folder::check(self)
    }
}

/// Where a file of the sweep is, for words to people.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}
