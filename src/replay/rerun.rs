//! Prepares and executes the re-run of a recorded run.

use crate::batch::{self, Batch, Findings, Interrupter, Options, Progress, simulate};
use crate::files::names;
use crate::replay::input_change::{InputChange, changes};
use crate::replay::recorded_run::RecordedRun;
use crate::replay::replay_error::ReplayError;
use crate::report::batch_page;
use crate::scenario;
use crate::sim::Problems;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A run that is ready to be re-run.
pub struct PreparedRerun {
    batch: Batch,
    path: PathBuf,
}

/// The result of a re-run.
#[derive(Clone, Debug)]
pub struct Rerun {
    /// Its files.
    pub run: RecordedRun,
    /// Changes of the inputs since the record.
    pub changes: Vec<InputChange>,
}

/// Reads the inputs of a run. Paths of its scenario are relative to `base`, or to the folder that
/// the record names. Results are written below `output`, with the selected contact problems. A
/// wall-clock limit terminates it like any run.
///
/// # Errors
/// The base folder is unknown; a file is missing or invalid; the output folder cannot be written.
pub fn prepare(
    recorded: &RecordedRun,
    base: Option<&Path>,
    output: &Path,
    timeout: Option<Duration>,
    problems: Problems,
) -> Result<PreparedRerun, ReplayError> {
    let record = &recorded.record;
    if record.metrics.remote_robot {
        return Err(ReplayError::RemoteRobot { record: recorded.path.clone() });
    }
    let folder = match (base, &record.timing.file) {
        (Some(base), _) => base.to_owned(),
        (None, Some(file)) => Path::new(file).parent().unwrap_or(Path::new("")).to_owned(),
        (None, None) => return Err(ReplayError::NoBaseFolder { record: recorded.path.clone() }),
    };
    let named = record.timing.file.as_ref().map(PathBuf::from).filter(|file| base.is_none() && file.is_relative());
    let invalid = |findings: Findings| ReplayError::Invalid {
        record: recorded.path.clone(),
        absent: named.clone().filter(|file| !file.exists()),
        findings: Box::new(findings),
    };
    // The scenario comes from the record; its file is named in errors and not read.
    let file = folder.join(format!("{}.toml", record.scenario));
    let parsed = scenario::parse(&file, record.resolved.as_str()).map_err(|diagnostics| {
        let mut findings = Findings::default();
        findings.extend(diagnostics);
        invalid(findings)
    })?;
    let (mut plan, _) = batch::prepare_loaded([(&parsed, &Vec::new())], scenario::DEFAULT_MAX_RUNS).map_err(invalid)?;
    if plan.runs() == 0 {
        return Err(invalid(Findings::default()));
    }
    plan.set_swept_parameters(&record.parameters);
    let path = plan.folder(0, output).join(names::RUN_RECORD);
    let options = Options {
        output: output.to_owned(),
        jobs: 1,
        log: recorded.log.is_some(),
        timeout,
        max_fail: None,
        slow: None,
        resume: false,
        problems,
        timing: false,
    };
    Ok(PreparedRerun { batch: Batch::new(plan, options, batch_page)?, path })
}

impl PreparedRerun {
    /// The `run.json` that it will write.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A handle that interrupts it from another thread.
    pub fn interrupter(&self) -> Interrupter {
        self.batch.interrupter()
    }

    /// Executes the re-run and compares its inputs with the record.
    ///
    /// # Errors
    /// It was interrupted, or its records cannot be written.
    pub fn run(self, recorded: &RecordedRun) -> Result<Rerun, ReplayError> {
        let report = self.batch.run(Progress::Silent, &simulate)?;
        if report.finished.is_empty() || report.interrupted {
            return Err(ReplayError::Interrupted);
        }
        let run = RecordedRun::read(&self.path)?;
        Ok(Rerun { changes: changes(&recorded.record, &run.record), run })
    }
}
