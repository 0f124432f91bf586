//! Errors of submitting a sweep.

use std::path::PathBuf;

use crate::files::RecordError;

/// Errors before or during a submission. No job remains unless the message names one.
#[derive(Debug, thiserror::Error)]
pub enum SubmitError {
    /// A text that cannot be written into a script.
    #[error("{what} cannot be written into a batch script: it has {why}: {text:?}")]
    Text {
        /// Name of the text.
        what: &'static str,
        /// The invalid part, such as a line break.
        why: &'static str,
        /// The text.
        text: String,
    },
    /// An option that this program sets itself.
    #[error("`--sbatch {option}` cannot be chosen: {why}")]
    Reserved {
        /// The option as typed.
        option: String,
        /// The part of the program that sets it.
        why: &'static str,
    },
    /// The folder has other results.
    #[error("{}: {what}; give this sweep another folder with -o", folder.display())]
    OtherResults {
        /// The results found.
        what: String,
        /// The folder.
        folder: PathBuf,
    },
    /// Jobs of this folder have not ended.
    #[error(
        "{}: its jobs have not ended yet ({jobs}); wait for them, or cancel them with `{command}`, and then submit again: \
         finished runs are kept", folder.display()
    )]
    Unfinished {
        /// The folder.
        folder: PathBuf,
        /// Jobs with their states.
        jobs: String,
        /// The command that cancels them.
        command: String,
    },
    /// A program of the engine cannot be started.
    #[error(
        "cannot start `{program}` of {engine}: {source}; submit on a machine that has it in its PATH, such as a login node of \
         the cluster, or see with --dry-run what would be submitted"
    )]
    NotFound {
        /// The program.
        program: &'static str,
        /// Name of the engine.
        engine: &'static str,
        /// The cause.
        source: std::io::Error,
    },
    /// The engine does not answer.
    #[error(
        "{engine} does not answer: `{command}` ended with {status}:\n{output}\nnothing was submitted; check that the cluster is up \
         and this machine belongs to it (`scontrol ping`), or see with --dry-run what would be submitted"
    )]
    NoAnswer {
        /// Name of the engine.
        engine: &'static str,
        /// The command.
        command: String,
        /// Its exit status.
        status: String,
        /// Its output.
        output: String,
    },
    /// More parts than runs.
    #[error("--parts {parts}: there are {runs} runs, and a part without a run needs no job; give at most {runs}")]
    MorePartsThanRuns {
        /// Requested parts.
        parts: u64,
        /// Runs of the whole plan.
        runs: u64,
    },
    /// More parts than a folder can have.
    #[error("--parts {parts}: at most {most} are allowed; put more runs into each part")]
    TooManyParts {
        /// Requested parts.
        parts: u64,
        /// Largest number allowed.
        most: u64,
    },
    /// More parts than the engine accepts.
    #[error("--parts {parts}: {engine} accepts at most {most} here ({because})")]
    ArrayTooLarge {
        /// Requested parts.
        parts: u64,
        /// Largest number allowed.
        most: u64,
        /// Name of the engine.
        engine: &'static str,
        /// The setting that limits it.
        because: &'static str,
    },
    /// The engine rejects a job.
    #[error("{engine} refuses: `{command}` ended with {status}:\n{output}\n{remaining}")]
    Refused {
        /// Name of the engine.
        engine: &'static str,
        /// The command.
        command: String,
        /// Its exit status.
        status: String,
        /// Its output.
        output: String,
        /// Remaining jobs, as text.
        remaining: String,
    },
    /// A file cannot be written, and a job remains.
    #[error("{error}; {remaining}")]
    JobRemains {
        /// The error of the file.
        error: Box<RecordError>,
        /// Remaining jobs, as text.
        remaining: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Why the outcome of the merge is unknown.
#[derive(Debug, thiserror::Error)]
pub enum WaitError {
    /// The system cannot wait for the program.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A signal terminated the program.
    #[error("{}", format!("{status} {output}").trim())]
    Signal {
        /// Its exit status.
        status: String,
        /// Its output.
        output: String,
    },
}
