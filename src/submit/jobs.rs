//! Reads and writes `jobs.json`, the record of a submission. It names the jobs and identifies the
//! plan, so that a later submission to the same folder can be compared with it.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::{RecordError, json};
use crate::input::{self, MOST_TEXT};

/// Format version of `jobs.json`.
pub const SUBMIT_SCHEMA: u32 = 1;

pub(super) use crate::files::names::JOBS;

/// A submitted sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Jobs {
    /// Format version, [`SUBMIT_SCHEMA`].
    pub schema: u32,
    /// Program and version.
    pub program: String,
    /// Name of the engine.
    pub engine: String,
    /// Number of parts.
    pub parts: u64,
    /// Runs of the whole plan.
    pub runs: usize,
    /// Hash of the plan, as in `shard.jsonl`.
    pub plan: String,
    /// Hashes of files, as in `shard.jsonl`.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// Command of every part, one entry per argument; the engine adds the number of the part.
    pub command: Vec<String>,
    /// Number of the job array.
    pub array: String,
    /// Number of the job that merges; none until it is submitted.
    pub merge: Option<String>,
}

impl Jobs {
    /// Reads the last submission; none if there is none.
    ///
    /// # Errors
    /// The file cannot be read, is invalid, or has another version.
    pub fn read(scripts: &Path) -> Result<Option<Self>, RecordError> {
        let path = scripts.join(JOBS);
        let bytes = match input::read(&path, MOST_TEXT) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            bytes => bytes.map_err(RecordError::io(&path))?,
        };
        json::parse(&bytes, &path, SUBMIT_SCHEMA).map(Some)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, scripts: &Path) -> Result<(), RecordError> {
        json::write_pretty(&scripts.join(JOBS), self)
    }
}
