//! Shards put together to the folder that one run of all would have left.
//!
//! Every shard says in its `shard.jsonl` which runs of the plan it has, and where in the plan they stand. Everything is checked
//! before anything is written: the shards are of one plan, all are there, every run has its record, and what two of them
//! have is the same in both. Lists and records are read one by one, so that memory does not grow with the number of runs.

mod gather;
mod logs;
mod look;
mod place;
mod references;
mod walk;

use crate::files::RecordError;
use crate::results::{SHARD_LIST, ShardHead, ShardList};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::path::{Component, Path, PathBuf};

pub use gather::Merged;
use look::Look;
use references::References;
use walk::Holder;

/// Runs that are named of those with the same trouble.
const MOST_NAMED: usize = 10;

/// Why shards cannot be put together. Nothing has been written, unless it is a file that could not be.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder that holds no shard.
    #[error("{}: no results of a shard: it has no {}", folder.display(), SHARD_LIST)]
    NoShard {
        /// The folder.
        folder: PathBuf,
    },
    /// Something that is no folder.
    #[error(
        "{}: it is {what}; wanted are the folders of results of all shards, as `runner run ... --shard I/N -o DIR` leaves them",
        path.display()
    )]
    NoFolder {
        /// What was named.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// The folder to write is one of those to read, or inside one.
    #[error(
        "{}: the folder to write is {}; name one outside of the results of all shards",
        output.display(),
        if folder == output { "one of those to read".to_owned() } else { format!("inside {}, which is to be read", folder.display()) }
    )]
    Onto {
        /// The folder to read.
        folder: PathBuf,
        /// The folder to write.
        output: PathBuf,
    },
    /// A folder to read stands where results would be written.
    #[error(
        "{}: results of the scenario `{scenario}` would be written into {}, which is to be read; name another folder with -o",
        output.display(), folder.display()
    )]
    Over {
        /// The folder to read.
        folder: PathBuf,
        /// The folder to write.
        output: PathBuf,
        /// The scenario of that name.
        scenario: String,
    },
    /// Two shards of different plans.
    #[error("{} and {} are no shards of one plan: {what}", a.display(), b.display())]
    OtherPlan {
        /// A folder.
        a: PathBuf,
        /// Another.
        b: PathBuf,
        /// What tells them apart.
        what: String,
    },
    /// What is missing or differs, one thing a line.
    #[error("{}", .0.join("\n"))]
    Runs(Vec<String>),
}

/// What shards do not have.
#[derive(Debug)]
pub struct Missing {
    /// In words, one thing a line; empty when everything is there.
    pub lines: Vec<String>,
    /// Shards and places of what is there and is no result to take.
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
    /// Reads what the folders are.
    ///
    /// # Errors
    /// One of them is no shard, or they are not of one plan.
    pub fn open(folders: &[PathBuf]) -> Result<Self, MergeError> {
        let heads = folders.iter().map(|folder| match ShardList::open(folder) {
            Ok(list) => Ok(list.head),
            Err(_) if !folder.is_dir() => {
                let what = if folder.exists() { "a file" } else { "not there" };
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
                () if head.program != first.program => format!("made by {} and {}", first.program, head.program),
                () if head.of != first.of => format!("one of {} and one of {}", first.of, head.of),
                () if head.runs != first.runs => format!("the plans have {} and {} runs", first.runs, head.runs),
                () if head.plan != first.plan => "their scenarios, values, robots or other files differ".to_owned(),
                () => continue,
            };
            return Err(MergeError::OtherPlan { a: shards.folders[0].clone(), b: folder.clone(), what });
        }
        Ok(shards)
    }

    /// Runs of the whole plan.
    pub fn runs(&self) -> usize {
        self.heads.first().map_or(0, |head| head.runs)
    }

    /// Looks at every run: is it there and whole, and the same wherever it is? Returns what there is not.
    ///
    /// # Errors
    /// Runs that two shards have and that differ; lists that contradict each other or cannot be read.
    pub fn check(&self) -> Result<Missing, MergeError> {
        let (mut looked, mut references) = (Look::new(self.folders.len()), References::default());
        let (mut place, mut gaps) = (0, 0);
        self.walk(&mut |holders: &[Holder]| {
            let run = &holders[0].run;
            gaps += run.at - place;
            place = run.at + 1;
            if let Some(other) = holders.iter().find(|h| h.run != *run) {
                return Err(self.contradiction(holders[0].shard, other.shard));
            }
            if let Some((holder, record)) = looked.at(holders) {
                references.note(self, holder, &record);
            }
            Ok(())
        })?;
        gaps += self.runs().saturating_sub(place);
        let mut lines = self.missing_shards();
        if gaps > 0 && lines.is_empty() {
            return Err(MergeError::Runs(vec![format!(
                "{gaps} runs of the plan are in no shard: lines of a {SHARD_LIST} are gone"
            )]));
        }
        let unlike = logs::unlike(self, &looked)?;
        let Look { absent, broken, .. } = looked.same()?;
        for (shard, lost) in absent.into_iter().enumerate() {
            lines.extend(lost.line(&self.name(shard)));
        }
        let references = references.same()?;
        lines.extend(references.lost(self));
        lines.extend(unlike);
        Ok(Missing { lines, broken, references })
    }

    /// `results-1 (shard 1/8)`
    fn name(&self, shard: usize) -> String {
        let (folder, head) = (self.folders[shard].display(), &self.heads[shard]);
        format!("{folder} (shard {}/{})", head.shard, head.of)
    }

    fn missing_shards(&self) -> Vec<String> {
        let Some(of) = self.heads.first().map(|head| head.of) else { return Vec::new() };
        let there = |number: &u64| self.heads.iter().any(|head| head.shard == *number);
        let numbers: Vec<u64> = (1..=of).filter(|number| !there(number)).collect();
        if numbers.is_empty() {
            return Vec::new();
        }
        let words: Vec<String> = numbers.iter().take(MOST_NAMED).map(u64::to_string).collect();
        let dots = if numbers.len() > MOST_NAMED { ", ..." } else { "" };
        vec![format!("{} of {of} shards are missing: {}{dots}", numbers.len(), words.join(", "))]
    }

    fn contradiction(&self, a: usize, b: usize) -> MergeError {
        let what = "their lists have different runs at one place".to_owned();
        MergeError::OtherPlan { a: self.folders[a].clone(), b: self.folders[b].clone(), what }
    }

    /// May this be the folder to write?
    ///
    /// # Errors
    /// It is one of those to read or inside one, or one of those to read would be written over as a scenario's results.
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
        self.walk(&mut |holders| {
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

/// The folder that is meant, without links and dots. What is not there yet will be a folder where its name says.
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
