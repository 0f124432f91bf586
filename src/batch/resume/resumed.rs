//! `--resume`: the runs of a plan that are done, by their records, and why the others are not.
//!
//! A run's key is a hash of everything its result depends on, so a whole record under the key of a run is that run's result.
//! What depended on the clock, on a person or on trouble of the machine is made again.

use crate::files::names;
use std::collections::{HashMap, HashSet};
use std::path::Path;

use crate::batch::dispatch::dispatcher::is_to_repeat;
use crate::batch::dispatch::finished_runs::Store;
use crate::batch::resume::rerun_reason;
use crate::batch::{Finished, Job, Options, Plan, Role};
use crate::files::{RecordError, remove_partial};
use crate::log::MAX_PROBLEMS;
use crate::results::{BUILD, ParamValue, RunRecord, SummaryRow, log_mismatch};
use crate::sim::{Outcome, Problems};

/// What is there already of a batch.
#[derive(Debug, Default)]
pub struct Resumed {
    pub(in crate::batch) finished: Store,
    pub(in crate::batch) references: Store,
    /// Runs that are done and are to be repeated for timing.
    pub(in crate::batch) again: Vec<usize>,
    stale: Vec<Rerun>,
    /// Places of the reasons.
    reasons: HashMap<String, usize>,
    first: usize,
    other_builds: usize,
}

/// Runs that were made before and are made again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rerun {
    /// Why, in words.
    pub why: String,
    /// How many.
    pub runs: usize,
    /// Scenario and label of the first of them.
    pub example: String,
}

impl Resumed {
    /// Runs that are done.
    pub fn runs(&self) -> usize {
        self.finished.count
    }

    /// References that are done and that no run waits for.
    pub fn references(&self) -> usize {
        self.references.count
    }

    /// Runs that are made again, by reason.
    pub fn again(&self) -> &[Rerun] {
        &self.stale
    }

    /// Runs that are made for the first time.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Of those that are done, how many another build of this version made.
    pub fn other_builds(&self) -> usize {
        self.other_builds
    }

    /// What is done, references first, with the runs that it is about.
    pub(in crate::batch) fn all<'a>(&'a self, plan: &'a Plan) -> impl Iterator<Item = (&'a Store, Job)> {
        let references = self.references.positions().map(|index| (&self.references, plan.reference(index)));
        references.chain(self.finished.positions().map(|index| (&self.finished, plan.job(index))))
    }

    fn tell(&mut self, why: String, job: &Job) {
        let place = *self.reasons.entry(why).or_insert_with_key(|why| {
            let example = format!("{} {}", job.run.name, job.label).trim_end().to_owned();
            self.stale.push(Rerun { why: why.clone(), runs: 0, example });
            self.stale.len() - 1
        });
        self.stale[place].runs += 1;
    }
}

/// What there is of one run.
enum State {
    Done {
        finished: Box<Finished>,
        other_build: bool,
    },
    /// It was made, but not so that its result could be taken; why.
    Rerun(String),
    Absent,
}

/// Looks for the records of a plan. NoListener else may be writing there: what was left unfinished is removed.
pub(in crate::batch) fn find_results(plan: &Plan, options: &Options) -> Resumed {
    let mut resumed = Resumed::default();
    let (mut absent, mut needed): (Vec<usize>, HashSet<usize>) = (Vec::new(), HashSet::new());
    for job in plan.jobs() {
        match state(&job, plan, options) {
            State::Done { finished, other_build } => {
                resumed.other_builds += usize::from(other_build);
                if is_to_repeat(&job, &finished) {
                    resumed.again.push(job.index);
                }
                resumed.finished.insert(job.index, *finished);
                continue;
            }
            State::Rerun(why) => resumed.tell(why, &job),
            State::Absent => absent.push(job.index),
        }
        needed.extend(job.reference());
    }
    for index in 0..plan.references() {
        let job = plan.reference(index);
        match state(&job, plan, options) {
            State::Done { .. } if needed.contains(&index) => {
                resumed.tell("runs that are made are compared with it, and its motion is in no file".into(), &job);
            }
            State::Done { finished, .. } => resumed.references.insert(index, *finished),
            State::Rerun(why) => resumed.tell(why, &job),
            State::Absent if needed.contains(&index) => {}
            State::Absent => resumed.tell("its record is not there".into(), &job),
        }
    }
    let mut earlier: HashMap<&str, Earlier> = HashMap::new();
    let keys: HashSet<String> =
        if absent.is_empty() { HashSet::new() } else { (0..plan.runs()).map(|index| plan.key(index)).collect() };
    for index in absent {
        let name = plan.scenario(index);
        let known = earlier.entry(name).or_insert_with(|| Earlier::of(&options.output, name, &keys));
        if known.is_empty() {
            resumed.first += 1;
            continue;
        }
        let job = plan.job(index);
        match known.like(&job).and_then(|record| rerun_reason::why(&job, &record)) {
            Some(why) => resumed.tell(why, &job),
            None => resumed.first += 1,
        }
    }
    resumed
}

fn state(job: &Job, plan: &Plan, options: &Options) -> State {
    let folder = job.folder(&options.output);
    remove_partial(&folder);
    let path = folder.join(names::RUN_RECORD);
    let record = match RunRecord::read(&path) {
        Ok(record) => record,
        Err(RecordError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => return State::Absent,
        Err(_) => return State::Rerun("its record is no whole record".into()),
    };
    if (&record.scenario, &record.key) != (&job.run.name, &job.key) {
        return State::Rerun("its record is that of another run".into());
    }
    // The key is that of the resolved scenario: the same run may stand in another sweep, under other columns.
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
        return State::Rerun("it has not the contact problems that are asked for".into());
    }
    if let Some(reference) = job.reference()
        && record.comparison.until_s.is_none()
        && !matches!(state(&plan.reference(reference), plan, options), State::Done { .. })
    {
        return State::Rerun("it was not compared: its reference did not end".into());
    }
    let files = [path, log, problems].into_iter().filter(|file| file.exists()).collect();
    let other_build = record.timing.build.is_some_and(|build| build != BUILD);
    let finished = Finished { files, notes: record.notes, accepted: !row.is_refused(), row };
    State::Done { finished: Box::new(finished), other_build }
}

/// Would the run end like this again?
fn repeats(row: &SummaryRow) -> bool {
    !matches!(row.outcome, Outcome::TimedOut | Outcome::Error | Outcome::Cancelled) || !row.is_refused()
}

fn has_problems(row: &SummaryRow, folder: &Path, wanted: Problems) -> bool {
    let met = match wanted {
        Problems::None => 0,
        Problems::Inconsistent => row.metrics.inconsistent,
        Problems::All => row.metrics.selections,
    };
    met == 0 || std::fs::read_dir(folder).is_ok_and(|files| files.count() as u64 >= met.min(MAX_PROBLEMS as u64))
}

/// Records of a scenario that no run of the plan has the key of.
struct Earlier {
    /// The folder of the last of each, by what distinguished the run and its seed.
    with_seed: HashMap<String, String>,
    /// The same without the seed, and the seed; none where there are several.
    without: HashMap<String, Option<(String, u64)>>,
    folder: std::path::PathBuf,
}

impl Earlier {
    fn of(results: &Path, scenario: &str, keys: &HashSet<String>) -> Self {
        let folder = results.join(scenario);
        let mut earlier = Earlier { with_seed: HashMap::new(), without: HashMap::new(), folder };
        let Ok(entries) = std::fs::read_dir(&earlier.folder) else { return earlier };
        let names = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned());
        let written = |name: &String| earlier.folder.join(name).join(names::RUN_RECORD).metadata()?.modified();
        let names = names.filter(|name| !keys.contains(name));
        let mut names: Vec<_> = names.filter_map(|name| Some((written(&name).ok()?, name))).collect();
        names.sort();
        for (_, name) in names {
            let Ok(record) = RunRecord::read(&earlier.folder.join(&name).join(names::RUN_RECORD)) else { continue };
            let (place, seed) = (identity(&record.parameters), record.seed);
            let own = Some((name.clone(), seed));
            let known = earlier.without.entry(place.clone()).or_insert_with(|| own.clone());
            *known = own.filter(|_| known.as_ref().is_some_and(|(_, other)| *other == seed));
            earlier.with_seed.insert(format!("{place} {seed}"), name);
        }
        earlier
    }

    fn is_empty(&self) -> bool {
        self.with_seed.is_empty()
    }

    /// The record of the run that had the same swept values and the same seed, if it is clear which that is.
    fn like(&self, job: &Job) -> Option<RunRecord> {
        let place = identity(&job.parameters());
        let same_seed = self.with_seed.get(&format!("{place} {}", job.run.scenario.seed));
        let name = same_seed.or_else(|| self.without.get(&place)?.as_ref().map(|(name, _)| name))?;
        RunRecord::read(&self.folder.join(name).join(names::RUN_RECORD)).ok()
    }
}

fn identity(parameters: &[(String, ParamValue)]) -> String {
    parameters.iter().map(|(name, value)| format!("{name}={value}\n")).collect()
}
