//! `--resume`: finds finished runs by their records, and why the others must run.
//!
//! A run's key hashes everything its result depends on, so a complete record under it is the
//! result. Runs that timed out, were cancelled or failed with an error run again unless that was
//! expected.

use crate::files::names;
use std::collections::{HashMap, HashSet, VecDeque};
use std::path::{Path, PathBuf};

use crate::batch::dispatch::finished_runs::Store;
use crate::batch::dispatch::search_watch::SearchWatch;
use crate::batch::resume::rerun_reason;
use crate::batch::{Finished, Job, Options, Plan, Role};
use crate::files::{RecordError, confined, modified, remove_partial, run_folders};
use crate::log::MAX_PROBLEMS;
use crate::results::{BUILD, ParamValue, RunRecord, SummaryRow, log_mismatch};
use crate::sim::{Outcome, Problems};

/// Existing results of a batch.
#[derive(Debug, Default)]
pub struct Resumed {
    pub(in crate::batch) finished: Store,
    pub(in crate::batch) references: Store,
    /// Finished runs still to be repeated for timing.
    pub(in crate::batch) to_repeat: Vec<usize>,
    reruns: Vec<Rerun>,
    /// Index of each reason in `reruns`.
    reasons: HashMap<String, usize>,
    first: usize,
    other_builds: usize,
}

/// Runs that have a record but must run again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rerun {
    /// The reason.
    pub why: String,
    /// Number of runs.
    pub runs: usize,
    /// Scenario and label of the first of them.
    pub example: String,
}

impl Resumed {
    /// Number of finished runs.
    pub fn runs(&self) -> usize {
        self.finished.count
    }

    /// Number of finished references that no run still needs.
    pub fn references(&self) -> usize {
        self.references.count
    }

    /// Runs that must run again, by reason.
    pub fn reruns(&self) -> &[Rerun] {
        &self.reruns
    }

    /// Number of runs that run for the first time.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Number of finished runs computed by another build of this version.
    pub fn other_builds(&self) -> usize {
        self.other_builds
    }

    /// All finished jobs with the store that holds them, references first.
    pub(in crate::batch) fn all<'a>(&'a self, plan: &'a Plan) -> impl Iterator<Item = (&'a Store, Job)> {
        let references = self.references.positions().map(|index| (&self.references, plan.reference(index)));
        references.chain(self.finished.positions().map(|index| (&self.finished, plan.job(index))))
    }

    fn add_rerun(&mut self, why: String, job: &Job) {
        let position = *self.reasons.entry(why).or_insert_with_key(|why| {
            let example = format!("{} {}", job.run.name, job.label).trim_end().to_owned();
            self.reruns.push(Rerun { why: why.clone(), runs: 0, example });
            self.reruns.len() - 1
        });
        self.reruns[position].runs += 1;
    }
}

/// State of one run's record.
enum State {
    Done {
        finished: Box<Finished>,
        other_build: bool,
    },
    /// A record exists but cannot be used; the reason.
    Rerun(String),
    Absent,
}

/// Finds the records of a plan and removes partial files. No other process may write there.
///
/// `chosen` are the runs that searches have chosen; their results choose further ones.
pub(in crate::batch) fn find_results(
    plan: &Plan,
    options: &Options,
    searches: &SearchWatch,
    chosen: Vec<usize>,
) -> Result<Resumed, RecordError> {
    let mut resumed = Resumed::default();
    let (mut absent, mut needed): (Vec<usize>, HashSet<usize>) = (Vec::new(), HashSet::new());
    let planned = (0..plan.runs()).filter(|index| plan.probe_place(*index).is_none());
    let mut due: VecDeque<usize> = planned.chain(chosen).collect();
    while let Some(index) = due.pop_front() {
        let job = plan.job(index);
        match state(&job, plan, options) {
            State::Done { finished, other_build } => {
                resumed.other_builds += usize::from(other_build);
                if finished.needs_repetitions(&job) {
                    resumed.to_repeat.push(job.index);
                }
                resumed.finished.insert(index, *finished);
                if plan.probe_place(index).is_some() {
                    let row = resumed.finished.row(index, plan, &options.output)?;
                    due.extend(searches.finished(plan, index, &row));
                }
                continue;
            }
            State::Rerun(why) => resumed.add_rerun(why, &job),
            State::Absent => absent.push(job.index),
        }
        needed.extend(job.reference());
    }
    for index in 0..plan.references() {
        let job = plan.reference(index);
        match state(&job, plan, options) {
            State::Done { .. } if needed.contains(&index) => {
                resumed.add_rerun(
                    "other runs that run again are compared with it, and its motion is not recorded".into(),
                    &job,
                );
            }
            State::Done { finished, .. } => resumed.references.insert(index, *finished),
            State::Rerun(why) => resumed.add_rerun(why, &job),
            State::Absent if needed.contains(&index) => {}
            State::Absent => resumed.add_rerun("its record is missing".into(), &job),
        }
    }
    let mut earlier: HashMap<&str, Earlier> = HashMap::new();
    let keys: HashSet<String> = if absent.is_empty() {
        HashSet::new()
    } else {
        (0..plan.runs()).filter(|index| plan.is_known(*index)).map(|index| plan.key(index)).collect()
    };
    for index in absent {
        let name = plan.scenario(index);
        let known = earlier.entry(name).or_insert_with(|| Earlier::of(&options.output, name, &keys));
        if known.is_empty() {
            resumed.first += 1;
            continue;
        }
        let job = plan.job(index);
        match known.like(&job).and_then(|record| rerun_reason::why(&job, &record)) {
            Some(why) => resumed.add_rerun(why, &job),
            None => resumed.first += 1,
        }
    }
    Ok(resumed)
}

fn state(job: &Job, plan: &Plan, options: &Options) -> State {
    let folder = job.folder(&options.output);
    adopt_folder(job, &options.output, &folder);
    remove_partial(&folder);
    let path = folder.join(names::RUN_RECORD);
    let record = match RunRecord::read(&path) {
        Ok(record) => record,
        Err(RecordError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => return State::Absent,
        Err(RecordError::Checksum { .. }) => return State::Rerun("its record is damaged".into()),
        Err(_) => return State::Rerun("its record is incomplete".into()),
    };
    if (&record.scenario, &record.key) != (&job.run.name, &job.key) {
        return State::Rerun("its record belongs to another run".into());
    }
    // Another sweep may contain the same resolved scenario under other summary columns.
    if job.role != Role::Reference && record.parameters != job.parameters() {
        return State::Rerun("other values are swept now".into());
    }
    let row = record.summary_row();
    if !repeats(&row) {
        return State::Rerun(format!("it ended as `{}`", row.outcome.name()));
    }
    let log = folder.join(names::LOG);
    if job.wants_log(options) {
        if record.log.is_none() && !log.exists() {
            return State::Rerun("it has no log".into());
        }
        if let Some(fault) = log_mismatch(&record, &log) {
            return State::Rerun(fault.reason().into());
        }
    }
    let problems = folder.join(names::PROBLEMS);
    if !has_problems(&row, &problems, options.problems) {
        return State::Rerun("its contact problems were not written as requested".into());
    }
    if let Some(reference) = job.reference()
        && record.comparison.until_s.is_none()
        && !matches!(state(&plan.reference(reference), plan, options), State::Done { .. })
    {
        return State::Rerun("it was not compared: its reference did not end".into());
    }
    let other_build = record.timing.build.is_some_and(|build| build != BUILD);
    let (recorded, accepted) = (modified(&path), !row.is_refused());
    let files = [path, log, problems].into_iter().filter(|file| file.exists()).collect();
    let finished = Finished { files, recorded, notes: record.notes, accepted, row, storage_full: false };
    State::Done { finished: Box::new(finished), other_build }
}

/// Moves results to the folder of their run: they are in another one if the scenario had another
/// number of runs, or an earlier version of the program wrote them. Where that fails, the run runs
/// again.
fn adopt_folder(job: &Job, results: &Path, folder: &Path) {
    if folder.join(names::RUN_RECORD).exists() || confined::check(results, folder).is_err() {
        return;
    }
    let is_usable = |other: &PathBuf| other.join(names::RUN_RECORD).exists() && confined::check(results, other).is_ok();
    let Some(other) = job.other_folders(results).find(is_usable) else { return };
    // Without a record, what is there is worthless.
    let _ = std::fs::remove_dir_all(folder);
    if let Some(above) = folder.parent() {
        let _ = std::fs::create_dir_all(above);
    }
    let _ = std::fs::rename(&other, folder);
}

/// True if a repetition would end in the same way.
fn repeats(row: &SummaryRow) -> bool {
    !matches!(row.outcome, Outcome::TimedOut | Outcome::Error | Outcome::Cancelled) || !row.is_refused()
}

fn has_problems(row: &SummaryRow, folder: &Path, requested: Problems) -> bool {
    let expected = match requested {
        Problems::None => 0,
        Problems::Inconsistent => row.metrics.inconsistent,
        Problems::All => row.metrics.selections,
    };
    expected == 0
        || std::fs::read_dir(folder).is_ok_and(|files| files.count() as u64 >= expected.min(MAX_PROBLEMS as u64))
}

/// Records of a scenario whose keys belong to no run of the plan.
struct Earlier {
    /// Folder of the latest record, by swept values and seed.
    with_seed: HashMap<String, PathBuf>,
    /// Folder and seed by swept values alone; none where several seeds exist.
    without_seed: HashMap<String, Option<(PathBuf, u64)>>,
    folder: PathBuf,
}

impl Earlier {
    fn of(results: &Path, scenario: &str, keys: &HashSet<String>) -> Self {
        let folder = results.join(scenario);
        let mut earlier = Earlier { with_seed: HashMap::new(), without_seed: HashMap::new(), folder };
        let names = run_folders(&earlier.folder).into_iter();
        let written = |name: &PathBuf| earlier.folder.join(name).join(names::RUN_RECORD).metadata()?.modified();
        let is_planned = |name: &PathBuf| name.file_name().is_some_and(|key| keys.contains(&*key.to_string_lossy()));
        let names = names.filter(|name| !is_planned(name));
        let mut names: Vec<_> = names.filter_map(|name| Some((written(&name).ok()?, name))).collect();
        names.sort();
        for (_, name) in names {
            let Ok(record) = RunRecord::read(&earlier.folder.join(&name).join(names::RUN_RECORD)) else { continue };
            let (values, seed) = (identity(&record.parameters), record.seed);
            let own = Some((name.clone(), seed));
            let known = earlier.without_seed.entry(values.clone()).or_insert_with(|| own.clone());
            *known = own.filter(|_| known.as_ref().is_some_and(|(_, other)| *other == seed));
            earlier.with_seed.insert(format!("{values} {seed}"), name);
        }
        earlier
    }

    fn is_empty(&self) -> bool {
        self.with_seed.is_empty()
    }

    /// The record with the same swept values and seed, or with the only seed those values have.
    fn like(&self, job: &Job) -> Option<RunRecord> {
        let values = identity(&job.parameters());
        let same_seed = self.with_seed.get(&format!("{values} {}", job.run.scenario.seed));
        let name = same_seed.or_else(|| self.without_seed.get(&values)?.as_ref().map(|(name, _)| name))?;
        RunRecord::read(&self.folder.join(name).join(names::RUN_RECORD)).ok()
    }
}

fn identity(parameters: &[(String, ParamValue)]) -> String {
    parameters.iter().map(|(name, value)| format!("{name}={value}\n")).collect()
}
