//! Errors of re-running a recorded run.

use crate::batch::{BatchError, Findings};
use crate::files::RecordError;
use std::path::PathBuf;

/// Why a run cannot be re-run.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// A record or a folder cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// No run has this key.
    #[error("no run below {results} has a key that begins with `{key}`")]
    UnknownKey {
        /// The beginning of the key.
        key: String,
        /// The searched folder.
        results: PathBuf,
    },
    /// Several keys begin with this text.
    #[error("`{key}` is the beginning of several keys: {found}")]
    AmbiguousKey {
        /// The beginning of the key.
        key: String,
        /// Scenarios and keys of the runs.
        found: String,
    },
    /// The record lacks the path of its scenario file.
    #[error("{record} does not name the base folder of the paths in its scenario; give it with `--base FOLDER`")]
    NoBaseFolder {
        /// The record.
        record: PathBuf,
    },
    /// The robot was simulated by another program.
    #[error("the robot of {record} was not simulated by that run (`robot.backend`), so it cannot be re-run")]
    RemoteRobot {
        /// The record.
        record: PathBuf,
    },
    /// The scenario, its robot or a file that it names is invalid.
    #[error("the run cannot be re-run from {record}{}", hint(.absent))]
    Invalid {
        /// The record.
        record: PathBuf,
        /// Its scenario file, if its path is relative and does not exist in the working directory.
        absent: Option<PathBuf>,
        /// The errors found.
        findings: Box<Findings>,
    },
    /// The run cannot be started, or its records cannot be written.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// The re-run was interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// Help for a record that was probably written in another working directory.
fn hint(absent: &Option<PathBuf>) -> String {
    let text = |file: &PathBuf| {
        format!(
            "; its scenario was {}, which does not exist in this directory: run this command where the batch was started, or \
             give the folder of its paths with `--base FOLDER`",
            file.display()
        )
    };
    absent.as_ref().map(text).unwrap_or_default()
}
