//! Merges shards into the folder of results that a single batch would have written.
//!
//! The `shard.jsonl` of each shard lists its runs with their indices in the plan. All checks come before any write: the shards
//! belong to one plan, none is missing, every run has its record, and copies of one run are equal. Lists and records are
//! read one by one, so memory does not grow with the number of runs.
//!
//! Imports `results::{record, summary, discovery}` and `files`. `runner merge` calls it.

mod copy_run;
mod merged;
mod missing_logs;
mod plan_walk;
mod record_difference;
mod references;
mod shard_check;

use crate::files::RecordError;
use crate::results::{SHARD_LIST, ShardHead, ShardList};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::path::{Component, Path, PathBuf};

pub use merged::Merged;
use plan_walk::Holder;
use references::References;
use shard_check::ShardCheck;

/// Number of runs named for one problem.
const MOST_NAMED: usize = 10;

/// Errors of merging. Nothing has been written, unless writing a file failed.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder that is not a shard.
    #[error("{}: not the results of a shard: it has no {}", folder.display(), SHARD_LIST)]
    NoShard {
        /// The folder.
        folder: PathBuf,
    },
    /// A path that is not a folder.
    #[error(
        "{}: {what}\nhelp: name the folders of results of all shards, as `runner run ... --shard I/N -o DIR` writes them",
        path.display()
    )]
    NoFolder {
        /// The path.
        path: PathBuf,
        /// Its state.
        what: &'static str,
    },
    /// The output folder is an input, or inside one.
    #[error(
        "{}: the output folder is {}\nhelp: name a folder outside the results of all shards",
        output.display(),
        if folder == output { "one of the inputs".to_owned() } else { format!("inside the input {}", folder.display()) }
    )]
    Onto {
        /// The input folder.
        folder: PathBuf,
        /// The output folder.
        output: PathBuf,
    },
    /// An input folder is at the path of a scenario's results.
    #[error(
        "{}: results of the scenario `{scenario}` would be written into the input {}\nhelp: name another folder with -o",
        output.display(), folder.display()
    )]
    Over {
        /// The input folder.
        folder: PathBuf,
        /// The output folder.
        output: PathBuf,
        /// The scenario of that name.
        scenario: String,
    },
    /// Two shards of different plans.
    #[error("{} and {} are not shards of one plan: {what}", a.display(), b.display())]
    OtherPlan {
        /// A folder.
        a: PathBuf,
        /// Another.
        b: PathBuf,
        /// The difference.
        what: String,
    },
    /// Missing or differing runs, one line each.
    #[error("{}", .0.join("\n"))]
    Runs(Vec<String>),
}

/// Missing parts of the results.
#[derive(Debug)]
pub struct Missing {
    /// One line of text each; empty when nothing is missing.
    pub lines: Vec<String>,
    /// Shard and plan index of unusable results.
    broken: BTreeSet<(usize, usize)>,
    references: References,
}

/// Shards of one plan.
#[derive(Debug)]
pub struct Shards {
    folders: Vec<PathBuf>,
    heads: Vec<ShardHead>,
}

impl Shards {
    /// Opens the folders of shards.
    ///
    /// # Errors
    /// A folder is not a shard, or they belong to different plans.
    pub fn open(folders: &[PathBuf]) -> Result<Self, MergeError> {
        let heads = folders.iter().map(|folder| match ShardList::open(folder) {
            Ok(list) => Ok(list.head),
            Err(_) if !folder.is_dir() => {
                let what = if folder.exists() { "a file, not a folder" } else { "no such folder" };
                Err(MergeError::NoFolder { path: folder.clone(), what })
            }
            Err(RecordError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
                Err(MergeError::NoShard { folder: folder.clone() })
            }
            Err(error) => Err(error.into()),
        });
        let shards = Shards { folders: folders.to_vec(), heads: heads.collect::<Result<_, _>>()? };
        for (folder, head) in shards.folders.iter().zip(&shards.heads).skip(1) {
            let first = &shards.heads[0];
            let what = match () {
                () if head.program != first.program => {
                    format!("their programs are {} and {}", first.program, head.program)
                }
                () if head.of != first.of => format!("one of {} and one of {}", first.of, head.of),
                () if head.runs != first.runs => format!("the plans have {} and {} runs", first.runs, head.runs),
                () if head.plan != first.plan => "their scenarios, values, robots or other files differ".to_owned(),
                () => continue,
            };
            return Err(MergeError::OtherPlan { a: shards.folders[0].clone(), b: folder.clone(), what });
        }
        Ok(shards)
    }

    /// Number of runs of the whole plan.
    pub fn runs(&self) -> usize {
        self.heads.first().map_or(0, |head| head.runs)
    }

    /// Checks that every run is present, whole, and equal in all shards that have it; returns what is missing.
    ///
    /// # Errors
    /// A run differs between shards; lists contradict each other or cannot be read.
    pub fn check(&self) -> Result<Missing, MergeError> {
        let (mut check, mut references) = (ShardCheck::new(self.folders.len()), References::default());
        let (mut next, mut gaps) = (0, 0);
        self.for_each_run(&mut |holders: &[Holder]| {
            let run = &holders[0].run;
            gaps += run.at - next;
            next = run.at + 1;
            if let Some(other) = holders.iter().find(|h| h.run != *run) {
                return Err(self.contradiction(holders[0].shard, other.shard));
            }
            if let Some((holder, record)) = check.check(holders) {
                references.add(self, holder, &record);
            }
            Ok(())
        })?;
        gaps += self.runs().saturating_sub(next);
        let mut lines = self.missing_shards();
        if gaps > 0 && lines.is_empty() {
            return Err(MergeError::Runs(vec![format!(
                "{gaps} runs of the plan are in no shard: a {SHARD_LIST} lacks lines"
            )]));
        }
        let missing_logs = missing_logs::missing_logs(self, &check)?;
        let ShardCheck { absent, broken, .. } = check.require_equal()?;
        for (shard, missing) in absent.into_iter().enumerate() {
            lines.extend(missing.line(&self.name(shard)));
        }
        let references = references.require_equal()?;
        lines.extend(references.missing(self));
        lines.extend(missing_logs);
        Ok(Missing { lines, broken, references })
    }

    /// Such as `results-1 (shard 1/8)`.
    fn name(&self, shard: usize) -> String {
        let (folder, head) = (self.folders[shard].display(), &self.heads[shard]);
        format!("{folder} (shard {}/{})", head.shard, head.of)
    }

    fn missing_shards(&self) -> Vec<String> {
        let Some(of) = self.heads.first().map(|head| head.of) else { return Vec::new() };
        let exists = |number: &u64| self.heads.iter().any(|head| head.shard == *number);
        let numbers: Vec<u64> = (1..=of).filter(|number| !exists(number)).collect();
        if numbers.is_empty() {
            return Vec::new();
        }
        let words: Vec<String> = numbers.iter().take(MOST_NAMED).map(u64::to_string).collect();
        let dots = if numbers.len() > MOST_NAMED { ", ..." } else { "" };
        vec![format!("{} of {of} shards are missing: {}{dots}", numbers.len(), words.join(", "))]
    }

    fn contradiction(&self, a: usize, b: usize) -> MergeError {
        let what = "their lists have different runs at one index".to_owned();
        MergeError::OtherPlan { a: self.folders[a].clone(), b: self.folders[b].clone(), what }
    }

    /// Checks the output folder.
    ///
    /// # Errors
    /// It is an input or inside one, or an input is at the path of a scenario's results.
    pub fn check_output(&self, output: &Path) -> Result<(), MergeError> {
        let to = real(output);
        let mut inside: BTreeMap<OsString, &PathBuf> = BTreeMap::new();
        for folder in &self.folders {
            let from = real(folder);
            if to.starts_with(&from) {
                return Err(MergeError::Onto { folder: folder.clone(), output: output.to_owned() });
            }
            let below = from.strip_prefix(&to).ok().and_then(|below| below.components().next());
            inside.extend(below.map(|name| (name.as_os_str().to_owned(), folder)));
        }
        if inside.is_empty() {
            return Ok(());
        }
        self.for_each_run(&mut |holders| {
            let scenario = &holders[0].run.scenario;
            match inside.get(OsStr::new(scenario)) {
                Some(folder) => Err(MergeError::Over {
                    folder: (*folder).clone(),
                    output: output.to_owned(),
                    scenario: scenario.clone(),
                }),
                None => Ok(()),
            }
        })
    }
}

/// The canonical path of a folder that may not exist yet.
fn real(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    absolute.components().fold(PathBuf::new(), |mut here, part| {
        match part {
            Component::ParentDir => _ = here.pop(),
            other => here.push(other),
        }
        here.canonicalize().unwrap_or(here)
    })
}
