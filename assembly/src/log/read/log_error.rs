//! Errors of reading a log.

use mcap::McapError;
use std::path::{Path, PathBuf};

/// Why a log cannot be read. Each message names the file.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}")]
    Io {
        /// The log.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file of another kind, or of another program.
    #[error("{path}: not a log of this program: {reason}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The missing part.
        reason: &'static str,
    },
    /// The file begins as a log and ends before its index.
    #[error(
        "{path}: cut short: after {length} bytes the index at the end of a log is missing; was it copied whole? `runner salvage` recovers what can be read"
    )]
    Truncated {
        /// The log.
        path: PathBuf,
        /// Length of the file, bytes.
        length: usize,
    },
    /// A record contradicts its checksum, its length or other records.
    #[error("{path}: damaged: {damage}; `runner salvage` recovers what can be read")]
    Damaged {
        /// The log.
        path: PathBuf,
        /// The contradiction.
        damage: Box<LogDamage>,
    },
}

impl LogError {
    /// The error of a damaged log.
    pub(super) fn damaged(path: &Path, damage: impl Into<LogDamage>) -> Self {
        Self::Damaged { path: path.to_owned(), damage: Box::new(damage.into()) }
    }
}

/// Damage of a log.
#[derive(Debug, thiserror::Error)]
pub enum LogDamage {
    /// A record is malformed or its checksum differs.
    #[error(transparent)]
    Mcap(#[from] McapError),
    /// The bytes of the file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The index refers to data beyond the end of the file.
    #[error("its index refers to data beyond its end")]
    IndexRange,
    /// The records are too long for the file's length.
    #[error("its records are more than {0} times as long as the file")]
    Inflated(usize),
    /// The metadata table `run` is incomplete.
    #[error("the metadata table `run` lacks the entry `{0}`")]
    RunEntry(&'static str),
    /// An attachment is not UTF-8.
    #[error("the attachment `{0}` is not UTF-8 text")]
    AttachmentText(String),
    /// A message does not have the form of its topic.
    #[error("a message on {topic}: {source}")]
    Message {
        /// The topic.
        topic: String,
        /// The cause.
        source: prost::DecodeError,
    },
    /// A channel lacks a metadata entry.
    #[error("{topic} has no `{entry}`")]
    ChannelEntry {
        /// The topic.
        topic: &'static str,
        /// The entry.
        entry: &'static str,
    },
    /// A metadata entry of a channel is not a list of names.
    #[error("`{entry}` of {topic}: {source}")]
    ChannelList {
        /// The topic.
        topic: &'static str,
        /// The entry.
        entry: &'static str,
        /// The cause.
        source: serde_json::Error,
    },
    /// `/state` has different numbers of joints and of their kinds.
    #[error("/state has {joints} joints and {kinds} kinds of joints")]
    JointKinds {
        /// Number of names.
        joints: usize,
        /// Number of kinds.
        kinds: usize,
    },
    /// Two topics have messages of different ticks.
    #[error("{topic} has other ticks than the topics before it: found {found}, expected {expected}")]
    Ticks {
        /// The topic.
        topic: &'static str,
        /// Number of its messages.
        found: usize,
        /// Number of ticks of the other topics.
        expected: usize,
    },
    /// Soles or vertices differ between ticks.
    #[error("/contact at {0} s has other soles or vertices than the first tick")]
    Soles(f64),
    /// Points of tasks differ between ticks.
    #[error("/state at {0} s has other points than the ticks before it")]
    Points(f64),
    /// The number of values is not the number of joints.
    #[error("/state at {time} s has {found} values for {joints} joints")]
    Joints {
        /// Simulated time, s.
        time: f64,
        /// Number of values.
        found: usize,
        /// Number of joints.
        joints: usize,
    },
    /// An estimate lacks values.
    #[error("/estimate at {0} s does not have a value for each joint and sole")]
    Estimate(f64),
    /// A message on self-collisions lacks values.
    #[error("/self_collision at {0} s does not have a value for each joint")]
    SelfCollision(f64),
    /// Objects differ between ticks.
    #[error("/tf does not have the same objects at every tick")]
    Objects,
    /// Frames differ between ticks.
    #[error("/tf at {0} ns has other frames than the first tick")]
    Frames(u64),
}
