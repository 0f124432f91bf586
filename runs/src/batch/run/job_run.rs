//! Executes one job and writes its record.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::batch::plan::input_hashes::input_hashes;
use crate::batch::run::awaited_reference::AwaitedReference;
use crate::batch::run::expectations::evaluate;
use crate::batch::run::plausibility::implausible;
use crate::batch::run::run_end::RunEnd;
use crate::batch::run::run_timer::Clock;
use crate::batch::{Body, Cancellation, Finished, Job, Options, Reason, Role, RunOutputs, Track};
use crate::files::{catch_panic, confined, modified, names, remove_partial};
use crate::results::{LogFingerprint, PROGRAM, RUN_SCHEMA, ReferenceMotion, RunRecord, Timing, TruthError, metric};
use crate::script::interruptible;
use crate::sim::{Metrics, Outcome, Problems, RunError};
use crate::text::length_limit::limit_length;
use crate::text::plural::plural;

/// Runs a job: simulates, compares, evaluates, writes `run.json` last. Every failure becomes the
/// run's outcome. Returns a reference's trajectory, or why there is none.
pub(in crate::batch) fn run(
    job: &Job,
    options: &Options,
    cancellation: &Cancellation,
    body: &Body<'_>,
    against: Option<&AwaitedReference>,
) -> (Finished, Result<ReferenceMotion, RunError>) {
    let folder = job.folder(&options.output);
    let confined = confined::check(&options.output, &folder);
    if confined.is_ok() {
        clear(&folder);
        let is_present = |other: &PathBuf| other.exists() && confined::check(&options.output, other).is_ok();
        for other in job.other_folders(&options.output).filter(is_present) {
            clear(&other);
            // It may have other files.
            let _ = std::fs::remove_dir(&other);
        }
    }
    let outputs = outputs(job, options, &folder, against);
    let clock = Clock::start();
    let mut end = match &confined {
        Ok(()) => catch_panic(|| interruptible(cancellation.shared(), || body(job, &outputs, cancellation.flag())))
            .unwrap_or_else(RunEnd::error),
        // Its files cannot be written.
        Err(error) => RunEnd::error(error.to_string()),
    };
    let timing = Timing { avoidance: end.avoidance, ..clock.read() };
    if end.outcome == Outcome::Cancelled && cancellation.reason() == Some(Reason::TimedOut) {
        end.outcome = Outcome::TimedOut;
        let limit = options.timeout.unwrap_or_default().as_secs_f64();
        end.message = format!("not at its end after {limit} s of wall-clock time");
    }
    let trajectory = take_trajectory(&mut end);
    let mut notes: Vec<_> = std::mem::take(&mut end.notes).into_iter().map(limit_length).collect();
    let mut storage_full = end.storage_full;
    let mut record = record(job, end, timing);
    record.comparison.reference = against.map(|a| a.key.clone());
    let gap = against.and_then(|a| not_compared(&record, a));
    record.comparison.whole = against.is_some() && gap.is_none();
    notes.extend(gap);
    notes.extend(inconsistent_note(job, &record.metrics));
    notes.extend(implausible(job, record.outcome, &record.metrics));
    record.notes.clone_from(&notes);
    record.comparison.truth = truths(job, &record);
    let (row, accepted) = evaluate(record.summary_row(), &job.run.scenario.expect);
    (record.outcome, record.message) = (row.outcome, row.message.clone());
    record.verdicts.clone_from(&row.verdicts);
    // A log that cannot be read now gets no fingerprint, so it never counts as complete.
    record.log = outputs.log.as_deref().and_then(|log| LogFingerprint::of(log).ok());
    let path = folder.join(names::RUN_RECORD);
    let written = [outputs.log, outputs.problems.map(|p| p.0)].into_iter().flatten().filter(|file| file.exists());
    let finished = match confined.and_then(|()| record.write(&path)) {
        Ok(()) => Finished {
            recorded: modified(&path),
            files: [path].into_iter().chain(written).collect(),
            notes,
            row,
            accepted,
            storage_full,
        },
        Err(error) => {
            storage_full |= error.is_storage_full();
            (record.outcome, record.message) = (Outcome::Error, error.to_string());
            let (files, row) = (written.collect(), record.summary_row());
            Finished { files, recorded: None, notes, row, accepted: false, storage_full }
        }
    };
    (finished, trajectory)
}

/// Removes an earlier record and log: a record exists only once its run has ended.
fn clear(folder: &Path) {
    if folder.symlink_metadata().is_err_and(|error| error.kind() == ErrorKind::NotFound) {
        return;
    }
    remove_partial(folder);
    for name in [names::RUN_RECORD, names::LOG] {
        // Writing the new file reports an obstacle that cannot be removed.
        let _ = std::fs::remove_file(folder.join(name));
    }
}

/// A reference keeps its motion; other runs write what the options request.
fn outputs(job: &Job, options: &Options, folder: &Path, against: Option<&AwaitedReference>) -> RunOutputs {
    if job.role == Role::Reference {
        return RunOutputs { track: Track::Keep(job.run.scenario.log.rate), ..RunOutputs::default() };
    }
    RunOutputs {
        log: job.wants_log(options).then(|| folder.join(names::LOG)),
        problems: (options.problems != Problems::None).then(|| (folder.join(names::PROBLEMS), options.problems)),
        track: against.and_then(|a| a.result.clone().ok()).map_or(Track::Nothing, Track::Compare),
    }
}

/// The trajectory of a run that ended normally, or why there is none.
fn take_trajectory(end: &mut RunEnd) -> Result<ReferenceMotion, RunError> {
    match (end.outcome, end.trajectory.take()) {
        (Outcome::Passed | Outcome::Fallen, Some(trajectory)) => Ok(trajectory),
        _ => Err(RunError::new(end.outcome, end.message.clone())),
    }
}

/// Why a run was not compared with its reference, or not to its end.
fn not_compared(record: &RunRecord, against: &AwaitedReference) -> Option<String> {
    let trajectory = match &against.result {
        Ok(trajectory) => trajectory,
        Err(reason) => return Some(format!("not compared: its reference {} {}", against.key, reason.with_outcome())),
    };
    match record.comparison.until_s {
        Some(until) if until < record.metrics.duration_s || until < trajectory.end() => {
            Some(format!("compared up to {until} s, the last instant that it and its reference both reached"))
        }
        Some(_) => None,
        None => Some("not compared: it has no instant in common with its reference".into()),
    }
}

/// Note on a reference with inconsistent selections.
fn inconsistent_note(job: &Job, metrics: &Metrics) -> Option<String> {
    let selections = plural(metrics.inconsistent as usize, "selection");
    (job.role == Role::Reference && metrics.inconsistent > 0)
        .then(|| format!("a reference with {selections} of a contact state without a valid one (`inconsistent`)"))
}

/// Absolute errors of measured values against known true values.
fn truths(job: &Job, record: &RunRecord) -> Vec<TruthError> {
    let row = record.summary_row();
    let known = job.run.scenario.compare.iter().flat_map(|compare| &compare.truth);
    let error = |name: &str, truth: f64| metric(&row, name).map(|measured| (measured - truth).abs());
    known.map(|(name, truth)| TruthError { metric: name.0.clone(), error: error(&name.0, *truth) }).collect()
}

fn record(job: &Job, end: RunEnd, timing: Timing) -> RunRecord {
    let scenario = &job.run.scenario;
    RunRecord {
        schema: RUN_SCHEMA,
        scenario: job.run.name.clone(),
        key: job.key.clone(),
        outcome: end.outcome,
        message: limit_length(end.message),
        method: scenario.contact.method.name().to_owned(),
        integrator: scenario.integrator.method.name().to_owned(),
        seed: scenario.seed,
        parameters: job.parameters(),
        verdicts: Vec::new(),
        metrics: end.metrics.unwrap_or_default(),
        comparison: end.comparison,
        notes: Vec::new(),
        program: PROGRAM.to_owned(),
        inputs: input_hashes(job),
        resolved: job.run.resolved_toml.clone(),
        log: None,
        timing: Timing { file: Some(job.run.file.display().to_string()), ..timing },
    }
}
