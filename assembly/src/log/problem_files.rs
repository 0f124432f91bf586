//! Writes and reads `problems/0001.json`, ...: contact problems of a run, for inspection and for
//! other solvers.

use crate::contact::selection_record::SelectionRecord;
use crate::files::{RecordError, atomic, if_present, json};
use crate::input::{self, MOST_DATA};
use crate::sim::Problems;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Format version of a problem file.
pub const PROBLEM_SCHEMA: u32 = 1;

/// Largest number of problem files of a run; further problems are only counted.
pub const MAX_PROBLEMS: usize = 100;

/// One problem file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemRecord {
    /// Format version, [`PROBLEM_SCHEMA`].
    pub schema: u32,
    /// Program and version.
    pub program: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// Number of the problem in the run, from 1.
    pub number: usize,
    /// The problem and its solution.
    pub selection: SelectionRecord,
}

impl ProblemRecord {
    /// Reads a problem file.
    ///
    /// # Errors
    /// No such file, invalid JSON, a field missing or unknown, a `null` (a number that was not
    /// finite), or another format version.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        json::parse(&input::read(path, MOST_DATA).map_err(RecordError::io(path))?, path, PROBLEM_SCHEMA)
    }
}

/// Writes the problems of one run.
#[derive(Debug)]
pub struct ProblemWriter {
    folder: PathBuf,
    scenario: String,
    key: String,
    which: Problems,
    count: usize,
}

impl ProblemWriter {
    /// Prepares to write to `folder`, which is created with the first problem. Removes the problems
    /// of an earlier run.
    ///
    /// # Errors
    /// Earlier problems cannot be removed.
    pub fn create(folder: PathBuf, scenario: &str, key: &str, which: Problems) -> Result<Self, RecordError> {
        if_present(std::fs::remove_dir_all(&folder)).map_err(RecordError::io(&folder))?;
        Ok(Self { folder, scenario: scenario.to_owned(), key: key.to_owned(), which, count: 0 })
    }

    /// The selections to write.
    pub fn which(&self) -> Problems {
        self.which
    }

    /// Folder of the problems; `None` without any.
    pub fn folder(&self) -> Option<&Path> {
        (self.count > 0).then_some(self.folder.as_path())
    }

    /// Writes a problem, or counts it if there are [`MAX_PROBLEMS`] already.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn write(&mut self, selection: &SelectionRecord) -> Result<(), RecordError> {
        self.count += 1;
        if self.count > MAX_PROBLEMS {
            return Ok(());
        }
        let record = ProblemRecord {
            schema: PROBLEM_SCHEMA,
            program: concat!("stiction ", env!("CARGO_PKG_VERSION")).to_owned(),
            scenario: self.scenario.clone(),
            key: self.key.clone(),
            number: self.count,
            selection: selection.clone(),
        };
        let path = self.folder.join(format!("{:04}.json", self.count));
        let mut text = json::compact(&record).map_err(|source| RecordError::Json { path: path.clone(), source })?;
        text.push(b'\n');
        atomic::write(&path, |out| out.write_all(&text).map_err(RecordError::io(&path)))
    }

    /// A note on problems that were not written, if any.
    pub fn summary(&self) -> Option<String> {
        let kind = if self.which == Problems::All { "selections" } else { "inconsistent selections" };
        let more = self.count.checked_sub(MAX_PROBLEMS).filter(|&n| n > 0);
        more.map(|n| format!("the first {MAX_PROBLEMS} of {} {kind} are written, {n} more are not", self.count))
    }
}
