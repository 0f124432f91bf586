//! `jobs.json`: what was submitted, so that it can be found, and told from what is submitted next.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::files::input::{self, MOST_TEXT};
use crate::files::{RecordError, atomic};

/// Format version of `jobs.json`.
pub const SUBMIT_SCHEMA: u32 = 1;

pub(super) use crate::files::names::JOBS;

/// A sweep that was submitted.
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
    /// A hash of them, as in `shard.jsonl`.
    pub plan: String,
    /// What every part runs, word by word; the engine adds which part it is.
    pub command: Vec<String>,
    /// Number of the array of jobs.
    pub array: String,
    /// Number of the job that merges; none until it was submitted.
    pub merge: Option<String>,
}

impl Jobs {
    /// Reads what was submitted last; none if nothing was.
    ///
    /// # Errors
    /// The file cannot be read, is none, or of another version.
    pub fn read(scripts: &Path) -> Result<Option<Self>, RecordError> {
        #[derive(Deserialize)]
        struct Version {
            schema: u64,
        }
        let path = scripts.join(JOBS);
        let json = |source| RecordError::Json { path: path.clone(), source };
        let bytes = match input::read(&path, MOST_TEXT) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            bytes => bytes.map_err(RecordError::io(&path))?,
        };
        let Version { schema } = serde_json::from_slice(&bytes).map_err(json)?;
        if schema != u64::from(SUBMIT_SCHEMA) {
            return Err(RecordError::Version { path, found: schema, expected: SUBMIT_SCHEMA });
        }
        serde_json::from_slice(&bytes).map(Some).map_err(json)
    }

    /// Writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, scripts: &Path) -> Result<(), RecordError> {
        let path = scripts.join(JOBS);
        atomic::write(&path, |out| {
            serde_json::to_writer_pretty(&mut *out, self)
                .map_err(|source| RecordError::Json { path: path.clone(), source })?;
            out.write_all(b"\n").map_err(RecordError::io(&path))
        })
    }
}
