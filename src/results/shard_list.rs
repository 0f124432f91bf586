//! `shard.jsonl`: the runs of a shard and their indices in the plan, from which `merge` finds
//! missing runs.
//!
//! The first line is a [`ShardHead`], each further one a [`ShardRun`], in the order of the plan.

use crate::files::input;
pub use crate::files::names::SHARD_LIST;
use crate::files::{RecordError, atomic, confined, json};
use crate::results::PROGRAM;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Format version of `shard.jsonl`.
pub const SHARD_SCHEMA: u32 = 1;

/// The shard and its plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardHead {
    /// Format version, [`SHARD_SCHEMA`].
    pub schema: u32,
    /// Program and version.
    pub program: String,
    /// Number of the shard, from 1.
    pub shard: u64,
    /// Number of shards.
    pub of: u64,
    /// Number of runs of all shards.
    pub runs: usize,
    /// A hash of their scenarios and keys in the order of the plan, hexadecimal.
    pub plan: String,
}

/// A run of a shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardRun {
    /// Index in the whole plan, from 0.
    pub at: usize,
    /// Name of the scenario.
    pub scenario: String,
    /// Key.
    pub key: String,
}

impl ShardRun {
    /// The folder of its record.
    pub fn folder(&self, results: &Path) -> PathBuf {
        results.join(&self.scenario).join(&self.key)
    }
}

impl ShardHead {
    /// The head of a shard of this program.
    pub fn new(shard: u64, of: u64, runs: usize, plan: String) -> Self {
        ShardHead { schema: SHARD_SCHEMA, program: PROGRAM.to_owned(), shard, of, runs, plan }
    }

    /// Writes the list into a folder of results.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, results: &Path, runs: impl Iterator<Item = ShardRun>) -> Result<(), RecordError> {
        let path = results.join(SHARD_LIST);
        atomic::write(&path, |out| {
            let mut line = |text: serde_json::Result<Vec<u8>>| {
                let mut text = text.map_err(|source| RecordError::Json { path: path.clone(), source })?;
                text.push(b'\n');
                out.write_all(&text).map_err(RecordError::io(&path))
            };
            line(serde_json::to_vec(self))?;
            for run in runs {
                line(serde_json::to_vec(&run))?;
            }
            Ok(())
        })
    }
}

/// A hash of the runs of a plan.
#[derive(Default)]
pub struct PlanHash(blake3::Hasher);

impl PlanHash {
    /// Adds the next run.
    pub fn add(&mut self, scenario: &str, key: &str) {
        // Names contain no zero byte.
        for name in [scenario, key] {
            self.0.update(name.as_bytes()).update(&[0]);
        }
    }

    /// The hash of all added runs.
    pub fn end(&self) -> String {
        self.0.finalize().to_hex()[..32].to_owned()
    }
}

/// An open `shard.jsonl`, read line by line.
pub struct ShardList {
    /// Its first line.
    pub head: ShardHead,
    path: PathBuf,
    lines: BufReader<File>,
}

impl ShardList {
    /// Opens the list of a folder of results.
    ///
    /// # Errors
    /// There is no list, or it is invalid or of another version.
    pub fn open(results: &Path) -> Result<Self, RecordError> {
        let path = results.join(SHARD_LIST);
        let mut lines = BufReader::new(input::open(&path).map_err(RecordError::io(&path))?.0);
        let mut text = String::new();
        lines.read_line(&mut text).map_err(RecordError::io(&path))?;
        Ok(ShardList { head: json::parse(text.as_bytes(), &path, SHARD_SCHEMA)?, path, lines })
    }

    /// Refuses names that are not plain folder names, since merging copies and removes folders of
    /// these names.
    fn checked(&self, run: ShardRun) -> Result<ShardRun, RecordError> {
        let invalid = [&run.scenario, &run.key].into_iter().find(|name| !confined::is_plain(name)).cloned();
        invalid.map_or(Ok(run), |name| Err(RecordError::Name { path: self.path.clone(), name }))
    }
}

impl Iterator for ShardList {
    type Item = Result<ShardRun, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut text = String::new();
        match self.lines.read_line(&mut text) {
            Ok(0) => None,
            Ok(_) => {
                let run = serde_json::from_str(&text);
                let run = run.map_err(|source| RecordError::Json { path: self.path.clone(), source });
                Some(run.and_then(|run| self.checked(run)))
            }
            Err(source) => Some(Err(RecordError::Io { path: self.path.clone(), source })),
        }
    }
}
