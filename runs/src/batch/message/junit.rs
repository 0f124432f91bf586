//! Writes a batch as JUnit XML.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::batch::{BatchError, Finished, Job, Listener, Plan, Role};
use crate::files::names::BATCH_FILES;
use crate::files::{OutputKind, RecordError, check_replaceable};
use crate::results::claims::{ClaimVerdict, Judgement};
use crate::results::searches::{SearchResult, SearchVerdict};
use crate::results::{JunitCase, JunitStatus, Verdict, write_junit};
use crate::sim::Outcome;
use crate::text::plural::plural;

/// Observes a batch and writes the outcome of every planned run.
pub struct Junit {
    path: PathBuf,
    output: PathBuf,
    slow: Option<Duration>,
    since: Instant,
    /// By their positions in the plan.
    runs: BTreeMap<usize, JunitCase>,
    references: Vec<JunitCase>,
    /// Results of searches.
    searches: Vec<JunitCase>,
    claims: Vec<JunitCase>,
}

impl Junit {
    /// Checks that the file can be written and marks all runs as skipped. `output` is the folder of
    /// the results; runs longer than `slow` are marked.
    ///
    /// # Errors
    /// The file's folder cannot be created or written.
    pub fn new(path: &Path, plan: &Plan, output: &Path, slow: Option<Duration>) -> Result<Self, BatchError> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
        tempfile::tempfile_in(folder).map_err(RecordError::io(folder))?;
        if path.is_dir() || becomes_folder(path, plan, output) {
            let source = std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a folder; test results need a file");
            return Err(RecordError::io(path)(source).into());
        }
        if is_at(path, output)
            && path.file_name().is_some_and(|name| BATCH_FILES.iter().any(|reserved| name == *reserved))
        {
            let source =
                std::io::Error::new(std::io::ErrorKind::InvalidInput, "is a file of the results: choose another");
            return Err(RecordError::io(path)(source).into());
        }
        check_replaceable(path, OutputKind::Junit)?;
        let mut names = HashMap::new();
        // Runs of searches get a case when they end.
        let planned = || (0..plan.runs()).filter(|index| plan.probe_place(*index).is_none());
        for job in planned().map(|index| plan.job(index)) {
            *names.entry((job.run.name.clone(), name(&job))).or_insert(0) += 1;
        }
        let case = |job: Job| {
            let label = name(&job);
            let shared = names.get(&(job.run.name.clone(), label.clone())).is_some_and(|count| *count > 1);
            // A name without the key identifies a case across batches.
            new_case(&job, if shared { format!("{label} {}", job.key) } else { label })
        };
        Ok(Junit {
            path: path.to_owned(),
            output: output.to_owned(),
            slow,
            since: Instant::now(),
            runs: planned().map(|index| (index, case(plan.job(index)))).collect(),
            references: (0..plan.references()).map(|index| case(plan.reference(index))).collect(),
            searches: Vec::new(),
            claims: Vec::new(),
        })
    }

    /// Writes the whole file in the order of the plan, in each suite reference runs first and claims last.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(self) -> Result<PathBuf, RecordError> {
        let mut order = HashMap::new();
        for case in self.runs.values() {
            let next = order.len();
            order.entry(case.suite.clone()).or_insert(next);
        }
        let mut cases: Vec<JunitCase> = self.references.into_iter().chain(self.runs.into_values()).collect();
        cases.extend(self.searches.into_iter().chain(self.claims));
        cases.sort_by_key(|case| order.get(&case.suite).copied());
        write_junit(&self.path, &cases, self.since.elapsed())?;
        Ok(self.path)
    }

    fn case(&mut self, job: &Job) -> Option<&mut JunitCase> {
        match job.role {
            Role::Reference => self.references.get_mut(job.index),
            Role::Run { .. } => Some(self.runs.entry(job.index).or_insert_with(|| new_case(job, name(job)))),
        }
    }
}

impl Listener for Junit {
    fn resumed(&mut self, job: &Job, finished: &Finished) {
        self.finished(job, finished);
        if let Some(case) = self.case(job) {
            case.properties.push(("resumed", "true".into()));
        }
    }

    fn finished(&mut self, job: &Job, finished: &Finished) {
        let (slow, folder) = (self.slow, job.folder(&self.output));
        let Some(case) = self.case(job) else { return };
        let row = &finished.row;
        case.time = Duration::try_from_secs_f64(row.wall_s).ok();
        case.status = status(finished);
        case.properties.push(("outcome", row.outcome.name().into()));
        case.properties.push(("folder", folder.display().to_string()));
        if is_slow(slow, row.wall_s) {
            case.properties.push(("slow", "true".into()));
        }
        case.output.clone_from(&finished.notes);
        if finished.accepted && !row.message.is_empty() {
            case.output.push(row.message.clone());
        }
    }

    fn not_needed(&mut self, index: usize) {
        if let Some(case) = self.runs.get_mut(&index) {
            case.status = JunitStatus::Skipped { message: "not needed: its claims are decided".into() };
        }
    }

    fn searched(&mut self, search: &SearchResult) {
        let message = search.summary();
        let label =
            format!("{}: {} over {} {}", search.search.name(), search.subject, search.keys.join(", "), search.label);
        let detail = || message.clone();
        let status = match search.verdict {
            SearchVerdict::Found => JunitStatus::Passed,
            SearchVerdict::Error => JunitStatus::Error { kind: "search".into(), message: detail() },
            _ => JunitStatus::Skipped { message: detail() },
        };
        self.searches.push(JunitCase {
            suite: search.scenario.clone(),
            name: label.trim_end().to_owned(),
            time: None,
            status,
            properties: vec![("verdict", search.verdict.name().into()), ("runs", search.runs.to_string())],
            output: vec![message],
        });
    }

    fn judged(&mut self, verdict: &ClaimVerdict) {
        let message = verdict.summary();
        let status = match verdict.verdict {
            Judgement::Holds => JunitStatus::Passed,
            Judgement::Fails => {
                JunitStatus::Failed { kind: "claim", detail: message.clone(), message: message.clone() }
            }
            Judgement::Undecided => JunitStatus::Skipped { message: message.clone() },
        };
        self.claims.push(JunitCase {
            suite: verdict.scenario.clone(),
            name: format!("claim: {}", verdict.name()),
            time: None,
            status,
            properties: vec![("verdict", verdict.verdict.name().into()), ("counted", verdict.used.to_string())],
            output: vec![message],
        });
    }
}

/// The case of a run that is not started.
fn new_case(job: &Job, name: String) -> JunitCase {
    JunitCase {
        suite: job.run.name.clone(),
        name,
        time: None,
        status: JunitStatus::Skipped { message: "not started".into() },
        properties: vec![("key", job.key.clone()), ("file", job.run.file.display().to_string())],
        output: Vec::new(),
    }
}

/// True if the batch uses this path as a folder: of the results, a parent of it, or of a scenario.
fn becomes_folder(path: &Path, plan: &Plan, output: &Path) -> bool {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (path, output) = (absolute(path), absolute(output));
    output.starts_with(&path) || plan.scenarios().any(|name| output.join(name) == path)
}

/// True if the file is directly in the folder.
fn is_at(path: &Path, folder: &Path) -> bool {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    matches!((parent.canonicalize(), folder.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// True if a run took longer than the limit.
pub fn is_slow(limit: Option<Duration>, wall_s: f64) -> bool {
    limit.is_some_and(|limit| wall_s > limit.as_secs_f64())
}

/// The run's label, or the scenario's name if it has none.
fn name(job: &Job) -> String {
    if job.label.is_empty() { job.run.name.clone() } else { job.label.clone() }
}

fn status(finished: &Finished) -> JunitStatus {
    let row = &finished.row;
    if finished.accepted {
        return JunitStatus::Passed;
    }
    match row.outcome {
        Outcome::Passed | Outcome::Failed | Outcome::Fallen => {
            let broken: Vec<&Verdict> = row.verdicts.iter().filter(|v| !v.held).collect();
            let count = plural(broken.len(), "broken expectation");
            let message = format!("{count} of {}: {}", row.verdicts.len(), row.message);
            JunitStatus::Failed {
                kind: "expectation",
                message,
                detail: broken.into_iter().map(detail).collect::<Vec<_>>().join("\n"),
            }
        }
        // A cancelled run has no result.
        Outcome::Cancelled => JunitStatus::Skipped { message: "interrupted".into() },
        outcome => {
            let kind = outcome.name();
            let message = if row.message.is_empty() { kind } else { &row.message };
            JunitStatus::Error { kind: kind.into(), message: message.into() }
        }
    }
}

/// `final_base_x: measured 0.4, expected 0.5 +- 0.01, error -0.1`
fn detail(verdict: &Verdict) -> String {
    let number = |x: Option<f64>| x.map_or_else(|| "nothing".to_owned(), |x| format!("{x:?}"));
    let expected = match (verdict.truth, verdict.allowed, verdict.min, verdict.max) {
        (Some(truth), allowed, ..) => format!("{truth:?} +- {:?}", allowed.unwrap_or(0.0)),
        (None, _, Some(min), Some(max)) => format!("{min:?} to {max:?}"),
        (None, _, Some(min), None) => format!("at least {min:?}"),
        (None, _, None, Some(max)) => format!("at most {max:?}"),
        // An expected outcome; the message names it.
        (None, _, None, None) => return format!("{}: {}", verdict.metric, verdict.message),
    };
    let error = verdict.error.map_or_else(String::new, |e| format!(", error {e:?}"));
    format!("{}: measured {}, expected {expected}{error}", verdict.metric, number(verdict.measured))
}
