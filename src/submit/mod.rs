//! Submits a sweep to a job scheduler (the engine) of a cluster: an array with one job per part,
//! then a job that merges the results. This folder has the parts common to all engines; each
//! engine has its own folder.
//!
//! ```text
//! DIR/part-0, DIR/part-1, ...   results of the parts (docs/scale.md)
//! DIR/results                   merged results, equal to those of one batch
//! DIR/submit                    scripts, jobs.json, output of the jobs
//! ```
//!
//! Shells and engines have different quoting rules for scripts, so this room quotes every argument
//! in them. Programs are started with a list of arguments, never through a shell.
//!
//! Imports: `input`, `files`, `results`. Used by: `cli`.

mod engine_command;
mod folder_check;
mod jobs;
mod quoting;
pub mod slurm;
mod submit_error;

use std::collections::BTreeMap;
use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::files::FileLock;

pub use jobs::{Jobs, SUBMIT_SCHEMA};
pub use submit_error::{SubmitError, WaitError};

/// Largest number of parts; each needs a line in the scripts and a folder.
const MAX_PARTS: u64 = 100_000;

/// A sweep to submit.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Absolute path of the program.
    pub runner: PathBuf,
    /// Arguments of `runner run` that all parts share: options and absolute paths of scenarios.
    pub arguments: Vec<String>,
    /// Parallel runs of a part; none: the number of processors of the job.
    pub jobs: Option<NonZero<usize>>,
    /// Absolute path of the folder of parts, results and scripts.
    pub folder: PathBuf,
    /// Number of parts.
    pub parts: NonZero<u64>,
    /// Runs of the whole plan.
    pub runs: usize,
    /// Hash of the plan, see [`crate::results::PlanHash`].
    pub plan: String,
    /// Hashes of the files that its runs use, by their names in the scenarios.
    pub files: BTreeMap<String, String>,
}

impl Sweep {
    /// Folder of the merged results.
    pub fn results(&self) -> PathBuf {
        self.folder.join("results")
    }

    /// Folder of scripts, `jobs.json` and the output of the jobs.
    pub fn scripts(&self) -> PathBuf {
        self.folder.join("submit")
    }

    /// Folder of a part, from 0.
    pub fn part(&self, number: u64) -> PathBuf {
        self.folder.join(format!("part-{number}"))
    }

    /// Checks the number of parts.
    ///
    /// # Errors
    /// There are more parts than runs, or more than 100 000.
    pub fn check_parts(&self) -> Result<(), SubmitError> {
        let (parts, runs) = (self.parts.get(), self.runs as u64);
        match parts {
            _ if parts > runs => Err(SubmitError::MorePartsThanRuns { parts, runs }),
            _ if parts > MAX_PARTS => Err(SubmitError::TooManyParts { parts, most: MAX_PARTS }),
            _ => Ok(()),
        }
    }

    /// Checks that the folder has no results of another plan; parts of this one are completed.
    ///
    /// # Errors
    /// It has other results, or cannot be read.
    pub fn check_folder(&self) -> Result<(), SubmitError> {
        folder_check::check(self)
    }

    /// Waits for other submissions to the folder, which is created if it is missing.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn lock(&self) -> Result<FileLock, SubmitError> {
        Ok(FileLock::wait(&self.folder.join("submit"))?)
    }
}

/// A path as text for messages and commands.
pub(crate) fn display(path: &Path) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_limited_by_runs_and_a_maximum() {
        let message = |parts, runs| {
            let parts = NonZero::new(parts).unwrap();
            let sweep = Sweep {
                runner: PathBuf::new(),
                arguments: Vec::new(),
                jobs: None,
                folder: PathBuf::new(),
                parts,
                runs,
                plan: String::new(),
                files: BTreeMap::new(),
            };
            sweep.check_parts().err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(message(100_000, 1_000_000), "");
        assert_eq!(
            message(100_001, 1_000_000),
            "--parts 100001: at most 100000 are allowed; put more runs into each part"
        );
        assert!(message(3, 2).contains("there are 2 runs"));
    }
}
