//! Shards of one plan, opened and checked against each other and the output folder.

use crate::files::RecordError;
use crate::merge::merge_error::MergeError;
use crate::results::{ResultsLock, ShardHead, ShardList};
use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Component, Path, PathBuf};

/// Shards of one plan.
#[derive(Debug)]
pub struct Shards {
    pub(super) folders: Vec<PathBuf>,
    pub(super) heads: Vec<ShardHead>,
    /// Shards that another program is writing, one line of text each.
    pub(super) busy: Vec<String>,
    /// Keep batches out of the others.
    _locks: Vec<ResultsLock>,
}

impl Shards {
    /// Opens the folders of shards, and locks those that no other program writes.
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
        let heads = heads.collect::<Result<Vec<_>, _>>()?;
        let (mut locks, mut busy) = (Vec::new(), Vec::new());
        for folder in folders {
            match ResultsLock::shared(folder) {
                Ok(lock) => locks.push(lock),
                Err(error @ RecordError::InUse { .. }) => busy.push(error.to_string()),
                Err(error) => return Err(error.into()),
            }
        }
        let shards = Shards { folders: folders.to_vec(), heads, busy, _locks: locks };
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
        shards.check_files()?;
        Ok(shards)
    }

    /// Checks that shards which use the same file found the same bytes.
    fn check_files(&self) -> Result<(), MergeError> {
        let mut known: BTreeMap<&str, (&str, usize)> = BTreeMap::new();
        for (shard, head) in self.heads.iter().enumerate() {
            for (name, hash) in &head.files {
                let (first, other) = *known.entry(name).or_insert((hash, shard));
                if first != hash {
                    let what = format!("a file differs: {name}");
                    let [a, b] = [other, shard].map(|shard| self.folders[shard].clone());
                    return Err(MergeError::OtherPlan { a, b, what });
                }
            }
        }
        Ok(())
    }

    /// Number of runs of the whole plan.
    pub fn runs(&self) -> usize {
        self.heads.first().map_or(0, |head| head.runs)
    }

    /// Such as `results-1 (shard 1/8)`.
    pub(super) fn name(&self, shard: usize) -> String {
        let (folder, head) = (self.folders[shard].display(), &self.heads[shard]);
        format!("{folder} (shard {}/{})", head.shard, head.of)
    }

    pub(super) fn contradiction(&self, a: usize, b: usize) -> MergeError {
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
                return Err(MergeError::OutputInInput { folder: folder.clone(), output: output.to_owned() });
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
                Some(folder) => Err(MergeError::InputInOutput {
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
