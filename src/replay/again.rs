//! One run, made again.

use super::changed::{Change, changes};
use super::{Left, ReplayError};
use crate::batch::{self, Batch, Findings, Interrupter, Options, Progress, simulate};
use crate::scenario;
use crate::sim::Problems;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A run that is ready to be made again.
pub struct Prepared {
    batch: Batch,
    path: PathBuf,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Again {
    /// What it left this time.
    pub left: Left,
    /// What of its inputs is not as it was.
    pub changes: Vec<Change>,
}

/// Reads what the run was made of. Paths of its scenario begin at `base`, or where the record says that they began; its
/// records go below `output`, with its contact problems if they are wanted. A wall-clock limit ends it as it ends any run.
///
/// # Errors
/// It is not known where paths begin; a file is not there any more or not as it must be; the folder cannot be written.
pub fn prepare(
    left: &Left,
    base: Option<&Path>,
    output: &Path,
    timeout: Option<Duration>,
    problems: Problems,
) -> Result<Prepared, ReplayError> {
    let record = &left.record;
    if record.metrics.remote_robot {
        return Err(ReplayError::Elsewhere { record: left.path.clone() });
    }
    let folder = match (base, &record.timing.file) {
        (Some(base), _) => base.to_owned(),
        (None, Some(file)) => Path::new(file).parent().unwrap_or(Path::new("")).to_owned(),
        (None, None) => return Err(ReplayError::Nowhere { record: left.path.clone() }),
    };
    let named = record.timing.file.as_ref().map(PathBuf::from).filter(|file| base.is_none() && file.is_relative());
    let invalid = |findings: Findings| ReplayError::Invalid {
        record: left.path.clone(),
        absent: named.clone().filter(|file| !file.exists()),
        findings: Box::new(findings),
    };
    // The file as it is now is not read: its name is that of the scenario.
    let file = folder.join(format!("{}.toml", record.scenario));
    let parsed = scenario::parse(&file, record.resolved.as_str()).map_err(|diagnostics| {
        let mut findings = Findings::default();
        findings.extend(diagnostics);
        invalid(findings)
    })?;
    let (mut plan, _) = batch::prepare_file(&parsed).map_err(invalid)?;
    if plan.runs() == 0 {
        return Err(invalid(Findings::default()));
    }
    plan.tell_as_swept(&record.parameters);
    let path = plan.folder(0, output).join("run.json");
    let options = Options {
        output: output.to_owned(),
        jobs: 1,
        log: left.log.is_some(),
        timeout,
        max_fail: None,
        slow: None,
        resume: false,
        problems,
        timing: false,
    };
    Ok(Prepared { batch: Batch::new(plan, options)?, path })
}

impl Prepared {
    /// The `run.json` that it will leave.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Interrupts it from elsewhere.
    pub fn interrupter(&self) -> Interrupter {
        self.batch.interrupter()
    }

    /// Runs it, after the run that it is compared with if there is one.
    ///
    /// # Errors
    /// It was interrupted, or its records cannot be written.
    pub fn run(self, then: &Left) -> Result<Again, ReplayError> {
        let report = self.batch.run(Progress::Silent, &simulate)?;
        if report.finished.is_empty() || report.interrupted {
            return Err(ReplayError::Interrupted);
        }
        let left = Left::read(&self.path)?;
        Ok(Again { changes: changes(&then.record, &left.record), left })
    }
}
