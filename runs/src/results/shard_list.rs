//! `shard.jsonl`: the runs of a shard and their indices in the plan, from which `merge` finds
//! missing runs.
//!
//! The first line is a [`ShardHead`], each further one a [`ShardRun`], in the order of the plan.

pub use crate::files::names::SHARD_LIST;
use crate::files::{KeyLevels, RecordError, atomic, confined, json};
use crate::input;
use crate::results::PROGRAM;
use crate::results::claims::{ClaimHead, RunClaim};
use crate::results::searches::SearchResult;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Format version of `shard.jsonl`.
pub const SHARD_SCHEMA: u32 = 1;

/// The shard and its plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// A hash of scenarios, their values and the filter, hexadecimal.
    pub plan: String,
    /// Hashes of the files that runs of the shard use, by their names in the scenarios.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// The claims about the runs of all shards.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<ClaimHead>,
    /// Number of planned runs of the shard that its searches have not chosen.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub unused: usize,
    /// Results of the shard's searches, once it is at its end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub searches: Vec<SearchResult>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(number: &usize) -> bool {
    *number == 0
}

/// Digits of a key.
const KEY_DIGITS: usize = 16;

/// A run of a shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardRun {
    /// Index in the whole plan, from 0.
    pub at: usize,
    /// Name of the scenario.
    pub scenario: String,
    /// Key.
    pub key: String,
    /// Folders between that of the scenario and that of the run.
    #[serde(default, skip_serializing_if = "KeyLevels::is_none")]
    pub levels: KeyLevels,
    /// Its parts in claims.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<RunClaim>,
}

impl ShardRun {
    /// The folder of its record.
    pub fn folder(&self, results: &Path) -> PathBuf {
        results.join(&self.scenario).join(self.levels.folder(&self.key))
    }

    /// Folders that it has as part of a scenario with another number of runs.
    pub fn other_folders(&self, results: &Path) -> impl Iterator<Item = PathBuf> {
        let scenario = results.join(&self.scenario);
        let other = KeyLevels::all().filter(|levels| *levels != self.levels);
        other.map(move |levels| scenario.join(levels.folder(&self.key)))
    }
}

impl ShardHead {
    /// The head of a shard of this program.
    pub fn new(shard: u64, of: u64, runs: usize, plan: String, files: BTreeMap<String, String>) -> Self {
        ShardHead {
            schema: SHARD_SCHEMA,
            program: PROGRAM.to_owned(),
            shard,
            of,
            runs,
            plan,
            files,
            claims: Vec::new(),
            unused: 0,
            searches: Vec::new(),
        }
    }

    /// A file that another shard found with other bytes.
    pub fn changed_file(&self, files: &BTreeMap<String, String>) -> Option<&str> {
        let changed = self.files.iter().find(|(name, hash)| files.get(*name).is_some_and(|other| other != *hash));
        changed.map(|(name, _)| name.as_str())
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
            line(json::compact(self))?;
            for run in runs {
                line(json::compact(&run))?;
            }
            Ok(())
        })
    }
}

/// A hash of what defines the runs of a plan.
#[derive(Default)]
pub struct PlanHash(blake3::Hasher);

impl PlanHash {
    /// Adds bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }

    /// The hash of all that was added.
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
    /// Number of lines read.
    line: usize,
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
        Ok(ShardList { head: json::parse(text.as_bytes(), &path, SHARD_SCHEMA)?, path, lines, line: 1 })
    }

    /// Refuses scenarios that are not plain folder names, and keys of another form than those of
    /// runs, since merging copies and removes folders of these names.
    fn checked(&self, run: ShardRun) -> Result<ShardRun, RecordError> {
        let is_key = run.key.len() == KEY_DIGITS && run.key.bytes().all(|byte| byte.is_ascii_hexdigit());
        let invalid = [(&run.scenario, confined::is_plain(&run.scenario)), (&run.key, is_key)];
        let invalid = invalid.into_iter().find(|(_, is_valid)| !is_valid).map(|(name, _)| name.clone());
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
                self.line += 1;
                let run = serde_json::from_str(&text).map_err(|error: serde_json::Error| {
                    // Its own line is always the first.
                    let text = error.to_string();
                    let what = text.split(" at line ").next().unwrap_or(&text);
                    let reason = format!("line {}, column {}: {what}", self.line, error.column());
                    RecordError::Json { path: self.path.clone(), source: serde::de::Error::custom(reason) }
                });
                Some(run.and_then(|run| self.checked(run)))
            }
            Err(source) => Some(Err(RecordError::Io { path: self.path.clone(), source })),
        }
    }
}
