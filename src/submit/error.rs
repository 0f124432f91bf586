//! What can go wrong before the jobs are with the engine.

use std::path::PathBuf;

use crate::files::RecordError;

/// Why nothing was submitted. Nothing of it is left with the engine unless the message says so.
#[derive(Debug, thiserror::Error)]
pub enum SubmitError {
    /// A word that cannot stand in a script.
    #[error("{what} cannot stand in a batch script: it has {why}: {word:?}")]
    Word {
        /// What it is.
        what: &'static str,
        /// What is wrong with it.
        why: &'static str,
        /// The word.
        word: String,
    },
    /// An option that this program gives itself.
    #[error("`--sbatch {option}` cannot be chosen: {why}")]
    Taken {
        /// As it was typed.
        option: String,
        /// Who gives it.
        why: &'static str,
    },
    /// The folder holds something else.
    #[error("{}: {what}; give this sweep another folder with -o", folder.display())]
    Other {
        /// What there is.
        what: String,
        /// The folder.
        folder: PathBuf,
    },
    /// Jobs of the folder have not ended.
    #[error(
        "{}: its jobs have not ended yet ({jobs}); wait for them, or end them with `{command}`, and then submit again: \
         what is done stays done", folder.display()
    )]
    Alive {
        /// The folder.
        folder: PathBuf,
        /// Jobs with their states.
        jobs: String,
        /// How they are ended.
        command: String,
    },
    /// A program of the engine is not there.
    #[error(
        "cannot start `{program}` of {engine}: {source}; submit on a machine that has it in its PATH, such as a login node of \
         the cluster, or see with --dry-run what would be submitted"
    )]
    Absent {
        /// The program.
        program: &'static str,
        /// Whose it is.
        engine: &'static str,
        /// The cause.
        source: std::io::Error,
    },
    /// The engine does not answer.
    #[error(
        "{engine} does not answer: `{command}` ended with {status}:\n{said}\nnothing was submitted; see whether the cluster is up \
         and this machine belongs to it (`scontrol ping`), or see with --dry-run what would be submitted"
    )]
    Silent {
        /// Whose program it was.
        engine: &'static str,
        /// What was asked.
        command: String,
        /// How it ended.
        status: String,
        /// What it said.
        said: String,
    },
    /// More parts than runs.
    #[error("--parts {parts}: there are {runs} runs, and a part without one is a job for nothing; give at most {runs}")]
    Idle {
        /// Wanted.
        parts: u64,
        /// Runs of the whole plan.
        runs: u64,
    },
    /// More parts than are made.
    #[error("--parts {parts}: at most {most} are made; give each part more runs")]
    TooManyParts {
        /// Wanted.
        parts: u64,
        /// Allowed.
        most: u64,
    },
    /// More parts than the engine takes.
    #[error("--parts {parts}: {engine} takes at most {most} here ({because})")]
    TooMany {
        /// Wanted.
        parts: u64,
        /// Allowed.
        most: u64,
        /// Whose limit.
        engine: &'static str,
        /// What sets it.
        because: &'static str,
    },
    /// The engine refuses.
    #[error("{engine} refuses: `{command}` ended with {status}:\n{said}\n{left}")]
    Refused {
        /// Who.
        engine: &'static str,
        /// What was asked.
        command: String,
        /// How it ended.
        status: String,
        /// What it said.
        said: String,
        /// What is left with the engine.
        left: String,
    },
    /// A file cannot be written, and a job is left.
    #[error("{error}; {left}")]
    Left {
        /// The file.
        error: Box<RecordError>,
        /// What is left with the engine.
        left: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
}
