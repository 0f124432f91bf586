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

/// Parts that a sweep is shared out in at most: each is a line of the scripts and a folder.
const MOST_PARTS: u64 = 100_000;

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
    /// A hash of them, see [`crate::results::PlanHash`].
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

    /// Has every part a run, and are there no more parts than can be written down in reasonable time?
    ///
    /// # Errors
    /// Not so.
    pub fn check_parts(&self) -> Result<(), SubmitError> {
        let (parts, runs) = (self.parts.get(), self.runs as u64);
        match parts {
            _ if parts > runs => Err(SubmitError::Idle { parts, runs }),
            _ if parts > MOST_PARTS => Err(SubmitError::TooManyParts { parts, most: MOST_PARTS }),
            _ => Ok(()),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_a_limit_and_a_run_each() {
        let told = |parts, runs| {
            let parts = NonZero::new(parts).unwrap();
            let sweep = Sweep {
                runner: PathBuf::new(),
                arguments: Vec::new(),
                jobs: None,
                folder: PathBuf::new(),
                parts,
                runs,
                plan: String::new(),
            };
            sweep.check_parts().err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(told(100_000, 1_000_000), "");
        assert_eq!(told(100_001, 1_000_000), "--parts 100001: at most 100000 are made; give each part more runs");
        assert!(told(3, 2).contains("there are 2 runs"));
    }
}
