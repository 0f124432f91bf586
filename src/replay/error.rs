//! Why a run cannot be run again.

use crate::batch::{BatchError, Findings};
use crate::files::RecordError;
use std::path::PathBuf;

/// Errors of this room.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// A record or a folder cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// No run has that key.
    #[error("no run below {results} has a key that begins with `{key}`")]
    Unknown {
        /// What was asked for.
        key: String,
        /// Where was looked.
        results: PathBuf,
    },
    /// Several runs have a key that begins so.
    #[error("`{key}` is the beginning of several keys: {found}")]
    Ambiguous {
        /// What was asked for.
        key: String,
        /// The runs, in words.
        found: String,
    },
    /// The record does not say where its scenario lay.
    #[error("{record} does not say where the paths of its scenario begin; `--base FOLDER` says it")]
    Nowhere {
        /// The record.
        record: PathBuf,
    },
    /// Its robot was somewhere else.
    #[error(
        "the robot of {record} was not simulated by that run (`robot.backend`): what it did there cannot be made again"
    )]
    Elsewhere {
        /// The record.
        record: PathBuf,
    },
    /// The scenario, its robot or a file it names is not as it should be.
    #[error("the run cannot be made again from {record}{}", hint(.absent))]
    Invalid {
        /// The record.
        record: PathBuf,
        /// Its scenario file, if that is named relatively and is not there from the working directory.
        absent: Option<PathBuf>,
        /// What is wrong.
        findings: Box<Findings>,
    },
    /// The run cannot be started, or its records cannot be written.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// It was interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// What helps where the record was probably written from another working directory.
fn hint(absent: &Option<PathBuf>) -> String {
    let words = |file: &PathBuf| {
        format!(
            "; its scenario was {}, which is not there from here: go where the batch was started, or say with `--base FOLDER` \
             where its paths begin",
            file.display()
        )
    };
    absent.as_ref().map(words).unwrap_or_default()
}
