//! Which runs there are to be shown: one log, or those of a folder of results.

use super::replay::ViewError;
use crate::files::RecordError;
use crate::files::input;
use crate::results::{RunRecord, read_records};
use std::path::{Path, PathBuf};

/// Runs with a log.
#[derive(Clone, Debug)]
pub struct Runs {
    shown: Vec<ShownRun>,
    without: usize,
}

/// One of them.
#[derive(Clone, Debug)]
pub struct ShownRun {
    /// Its log.
    pub log: PathBuf,
    /// Its record; none for a log that stands alone.
    pub record: Option<Box<RunRecord>>,
}

impl Runs {
    /// The run of a log or of a run's folder, or those of a folder of results in the order of its summary, and what of these
    /// cannot be read.
    ///
    /// # Errors
    /// There is no such file or folder.
    pub fn find(path: &Path) -> Result<(Self, Vec<RecordError>), ViewError> {
        let within = path.join("log.mcap");
        if !path.is_dir() || within.is_file() {
            let log = if path.is_dir() { within } else { path.to_owned() };
            // Read when it is asked for; only whether it is there can be told now.
            input::open(&log).map_err(|source| ViewError::Io { path: log.clone(), source })?;
            let record = RunRecord::read(&log.with_file_name("run.json")).ok().map(Box::new);
            return Ok((Self { shown: vec![ShownRun { log, record }], without: 0 }, Vec::new()));
        }
        let found = read_records(path).map_err(|error| match error {
            RecordError::Io { path, source } => ViewError::Io { path, source },
            other => ViewError::Io { path: path.to_owned(), source: std::io::Error::other(other) },
        })?;
        let total = found.runs.len();
        let logged = found.runs.into_iter().filter_map(|run| {
            let log = run.files.iter().find(|file| file.ends_with("log.mcap"))?.clone();
            Some(ShownRun { log, record: Some(Box::new(run.record)) })
        });
        let shown: Vec<_> = logged.collect();
        let without = total - shown.len();
        Ok((Self { shown, without }, found.skipped))
    }

    /// The runs.
    pub fn shown(&self) -> &[ShownRun] {
        &self.shown
    }

    /// How many runs of the folder left no log.
    pub fn without_log(&self) -> usize {
        self.without
    }
}

impl ShownRun {
    /// What to call it.
    pub fn title(&self) -> String {
        match &self.record {
            Some(record) => format!("{} {}", record.scenario, record.key),
            None => self.log.display().to_string(),
        }
    }
}
