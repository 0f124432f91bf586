//! Finds the runs to show: one log, or those of a folder of results.

use crate::files::RecordError;
use crate::files::names;
use crate::input;
use crate::results::{RunRecord, read_records};
use crate::view::view_error::ViewError;
use std::path::{Path, PathBuf};

/// Runs with a log.
#[derive(Clone, Debug)]
pub struct ViewableRuns {
    runs: Vec<ViewableRun>,
    /// Number of runs without a log.
    without_log: usize,
}

/// A run with a log.
#[derive(Clone, Debug)]
pub struct ViewableRun {
    /// Its log.
    pub log: PathBuf,
    /// Its record; none for a single log.
    pub record: Option<Box<RunRecord>>,
}

impl ViewableRuns {
    /// Finds the run of a log or of a run's folder, or the runs of a folder of results in the order
    /// of its summary. Also returns the errors of records that cannot be read.
    ///
    /// # Errors
    /// There is no such file or folder.
    pub fn find(path: &Path) -> Result<(Self, Vec<RecordError>), ViewError> {
        let within = path.join(names::LOG);
        if !path.is_dir() || within.is_file() {
            let log = if path.is_dir() { within } else { path.to_owned() };
            // The log is read when a browser requests it; now only its existence is checked.
            input::open(&log).map_err(|source| ViewError::Io { path: log.clone(), source })?;
            let record = RunRecord::read(&log.with_file_name(names::RUN_RECORD)).ok().map(Box::new);
            return Ok((Self { runs: vec![ViewableRun { log, record }], without_log: 0 }, Vec::new()));
        }
        let found = read_records(path)?;
        let total = found.runs.len();
        let logged = found.runs.into_iter().filter_map(|run| {
            let log = run.files.iter().find(|file| file.ends_with(names::LOG))?.clone();
            Some(ViewableRun { log, record: Some(Box::new(run.record)) })
        });
        let runs: Vec<_> = logged.collect();
        let without_log = total - runs.len();
        Ok((Self { runs, without_log }, found.skipped))
    }

    /// The runs.
    pub fn runs(&self) -> &[ViewableRun] {
        &self.runs
    }

    /// Number of runs of the folder without a log.
    pub fn without_log(&self) -> usize {
        self.without_log
    }
}

impl ViewableRun {
    /// Its title.
    pub fn title(&self) -> String {
        match &self.record {
            Some(record) => format!("{} {}", record.scenario, record.key),
            None => self.log.display().to_string(),
        }
    }
}
