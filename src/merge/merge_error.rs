//! Errors of merging.

use crate::files::RecordError;
use crate::results::SHARD_LIST;
use std::path::PathBuf;

/// Number of runs named for one problem.
pub(super) const MAX_NAMED: usize = 10;

/// Errors of merging. Nothing has been written, unless writing a file failed, or another program changed
/// the results of a shard meanwhile.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder that is not a shard.
    #[error("{}: not the results of a shard: {} is missing", folder.display(), SHARD_LIST)]
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
    OutputInInput {
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
    InputInOutput {
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
    /// Results that another program changed after they were checked.
    #[error("{}: changed while it was merged: {what}; merge again", path.display())]
    Changed {
        /// A folder of a shard.
        path: PathBuf,
        /// What changed.
        what: String,
    },
    /// Missing or differing runs, one line each.
    #[error("{}", .0.join("\n"))]
    Runs(Vec<String>),
}
