//! Exit codes, which scripts rely on; the source of help, manual pages and a test of docs/ci.md.

use std::error::Error;
use std::io::ErrorKind;
use std::process::{ExitCode, Termination};

use crate::batch::Report;
use crate::results::claims::Judgement;

/// How the program ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Exit {
    /// Success.
    Success = 0,
    /// An expectation did not hold, or something differs.
    Failed = 1,
    /// Wrong usage or invalid input; nothing was done.
    Invalid = 2,
    /// A run did not finish, or output could not be written completely.
    Unfinished = 3,
    /// There is nothing to do.
    Nothing = 4,
    /// A claim is undecided, or a search has no result.
    Undecided = 5,
    /// Interrupted by SIGINT: 128 plus its number.
    Interrupted = 130,
    /// Terminated by SIGTERM: 128 plus its number.
    Terminated = 143,
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self as u8)
    }
}

impl Exit {
    /// Exit code of a write error: `Invalid` if the path is wrong, else, as on a full disk,
    /// `Unfinished`.
    pub fn of_writing(error: &(dyn Error + 'static)) -> Self {
        let (mut cause, mut kind) = (Some(error), None);
        while let Some(error) = cause {
            kind = kind.or(error.downcast_ref::<std::io::Error>().map(std::io::Error::kind));
            cause = error.source();
        }
        match kind {
            Some(
                ErrorKind::NotFound
                | ErrorKind::PermissionDenied
                | ErrorKind::AlreadyExists
                | ErrorKind::NotADirectory
                | ErrorKind::IsADirectory
                | ErrorKind::ReadOnlyFilesystem
                | ErrorKind::InvalidInput
                | ErrorKind::InvalidFilename,
            ) => Exit::Invalid,
            _ => Exit::Unfinished,
        }
    }
}

/// How a batch ended, as far as its exit code depends on it.
#[derive(Clone, Copy, Debug)]
pub struct Ending {
    /// The code of the signal that interrupted it, if one did.
    pub interrupted: Option<Exit>,
    /// A run or a reference run did not finish, other than as expected.
    pub unfinished: bool,
    /// An expectation did not hold, or a claim fails.
    pub failed: bool,
    /// A claim is undecided, or a search has no result.
    pub undecided: bool,
}

impl Exit {
    /// The exit code of a batch: the first that applies of interrupted, unfinished, failed, undecided.
    pub fn of_ending(ending: Ending) -> Self {
        match ending {
            Ending { interrupted: Some(exit), .. } => exit,
            Ending { unfinished: true, .. } => Exit::Unfinished,
            Ending { failed: true, .. } => Exit::Failed,
            Ending { undecided: true, .. } => Exit::Undecided,
            _ => Exit::Success,
        }
    }

    /// The exit code of a batch by its report; `signal` is that of an interruption.
    pub fn of_batch(report: &Report, signal: Exit) -> Self {
        let interrupted = report.interrupted.then_some(signal);
        Self::of_ending(Ending {
            interrupted,
            unfinished: report.has_unfinished(),
            failed: report.has_failed() || report.has_claim(Judgement::Fails),
            undecided: report.has_claim(Judgement::Undecided) || report.has_open_search(),
        })
    }
}

/// Exit codes of a command with their meanings.
pub type Codes = [(Exit, &'static str)];

const SCENARIO: &str = "wrong usage, or a scenario, robot or filter is invalid";
const NOTHING: &str = "nothing selected: no scenario in a folder, no run left by the filter";
const UNDECIDED: &str = "no claim fails, and one is undecided, or a search has no result";
const STDOUT: &str = "standard output could not be written to the end";
const FILE: &str = "a file or standard output could not be written to the end";

/// What the exit codes of a command mean; `runner` alone is `run`.
pub fn codes(command: &str) -> &'static Codes {
    match command {
        "check" => &[
            (Exit::Success, "all is valid"),
            (Exit::Invalid, SCENARIO),
            (Exit::Unfinished, STDOUT),
            (Exit::Nothing, NOTHING),
        ],
        "list" => &[
            (Exit::Success, "listed"),
            (Exit::Invalid, SCENARIO),
            (Exit::Unfinished, STDOUT),
            (Exit::Nothing, NOTHING),
        ],
        "inspect" => &[
            (Exit::Success, "described"),
            (Exit::Invalid, "wrong usage, or a robot that is invalid or cannot be read"),
            (Exit::Unfinished, STDOUT),
        ],
        "convert" => &[
            (Exit::Success, "written"),
            (
                Exit::Invalid,
                "wrong usage, a robot that is invalid or cannot be read, or a path that exists or cannot be written",
            ),
            (Exit::Unfinished, FILE),
        ],
        "report" => &[
            (Exit::Success, "written"),
            (Exit::Invalid, "wrong usage, no such run, no records in the folder, or a path that cannot be written"),
            (Exit::Unfinished, FILE),
        ],
        "merge" => &[
            (Exit::Success, "all runs finished, every expectation and claim held"),
            (Exit::Failed, "an expectation did not hold, or a claim fails"),
            (
                Exit::Invalid,
                "wrong usage, results of other plans, runs that are missing or differ; nothing was written",
            ),
            (
                Exit::Unfinished,
                "a run or a reference run did not finish, or standard output could not be written to the end",
            ),
            (Exit::Undecided, UNDECIDED),
        ],
        "submit" => &[
            (Exit::Success, "submitted; with --wait: merged, all runs finished, every expectation and claim held"),
            (Exit::Failed, "with --wait: an expectation did not hold, or a claim fails"),
            (
                Exit::Invalid,
                "wrong usage, an invalid scenario, no cluster, other results in the folder: nothing was submitted; with \
                 --wait also: the merge found that results are missing",
            ),
            (Exit::Unfinished, "with --wait: a run or a reference run did not finish"),
            (Exit::Nothing, NOTHING),
            (Exit::Undecided, "with --wait: no claim fails, and one is undecided"),
        ],
        "compare" => &[
            (
                Exit::Success,
                "all values within their tolerances, the same runs in both; with --baseline also: no trend, every claim \
                 about changes holds",
            ),
            (
                Exit::Failed,
                "a value beyond its tolerance, an outcome or verdict changed, or a run that only one of them has; with \
                 --baseline also: a trend, or a claim about changes fails",
            ),
            (
                Exit::Invalid,
                "wrong usage, results or a baseline that cannot be read, or a history whose path cannot be written",
            ),
            (Exit::Unfinished, "a history or standard output could not be written to the end"),
            (Exit::Nothing, "no runs in either"),
            (Exit::Undecided, "with --baseline: nothing differs, and a claim about changes is undecided"),
        ],
        "export" => &[
            (Exit::Success, "written"),
            (
                Exit::Invalid,
                "wrong usage, a log that cannot be read, nothing to export, or a path that cannot be written",
            ),
            (Exit::Unfinished, FILE),
        ],
        "fit" => &[
            (
                Exit::Success,
                "fitted: all parameters are determined, residuals agree with given noise, and so do held-out data",
            ),
            (Exit::Failed, "residuals exceed the given noise, or held-out data differ from the fit"),
            (Exit::Invalid, "wrong usage, an invalid fit file, data or scenario, or a path that cannot be written"),
            (
                Exit::Unfinished,
                "not converged, a run that is needed does not reach the end of its data, or a file or standard output could \
                 not be written to the end",
            ),
            (Exit::Undecided, "the data do not determine all parameters, or an estimate is at a bound"),
            (Exit::Interrupted, "interrupted by Ctrl-C (SIGINT)"),
            (Exit::Terminated, "interrupted by SIGTERM"),
        ],
        "salvage" => &[
            (Exit::Success, "written"),
            (
                Exit::Invalid,
                "wrong usage, a log of which nothing can be read, or a path that cannot be written; other logs are written",
            ),
            (Exit::Unfinished, FILE),
            (Exit::Nothing, "no unfinished logs in the folders"),
        ],
        "replay" => &[
            (Exit::Success, "every run gave the same bits"),
            (Exit::Failed, "a run differs from its record or log"),
            (Exit::Invalid, "wrong usage, no such run, or a run that cannot be repeated"),
            (Exit::Unfinished, "--timeout ended a run, or a file or standard output could not be written to the end"),
            (Exit::Nothing, "nothing selected: no runs in the folder"),
            (Exit::Interrupted, "interrupted by Ctrl-C (SIGINT)"),
            (Exit::Terminated, "interrupted by SIGTERM"),
        ],
        "motor-server" => &[
            (Exit::Success, "the run reached its end and every expectation held"),
            (Exit::Failed, "an expectation did not hold"),
            (
                Exit::Invalid,
                "wrong usage, an invalid scenario, not one run, no key for an address beyond loopback, an address of --live that \
                 cannot be used",
            ),
            (
                Exit::Unfinished,
                "the run did not finish, the address could not be bound, or the task side left or went silent",
            ),
            (Exit::Nothing, NOTHING),
            (Exit::Interrupted, "interrupted by Ctrl-C (SIGINT)"),
            (Exit::Terminated, "interrupted by SIGTERM"),
        ],
        "console" => &[
            (Exit::Success, "all lines were executed and every `expect` held"),
            (Exit::Failed, "an `expect` did not hold, or the condition of `run until` was not met"),
            (
                Exit::Invalid,
                "wrong usage, an invalid scenario, not one run, or an invalid line of a script, such as one with a file that cannot be read or written",
            ),
            (Exit::Unfinished, "the run broke down, or a file could not be written to its end"),
            (Exit::Nothing, NOTHING),
            (Exit::Interrupted, "interrupted by Ctrl-C (SIGINT); in an interactive session Ctrl-C pauses the run"),
            (Exit::Terminated, "interrupted by SIGTERM"),
        ],
        "view" => &[
            (Exit::Success, "shown until Ctrl-C or SIGTERM, or the file is written"),
            (
                Exit::Invalid,
                "wrong usage, no such log, a log that cannot be shown, a port that is taken, or a path that cannot be \
                 written",
            ),
            (Exit::Unfinished, FILE),
            (Exit::Nothing, "no run of the folder left a log"),
        ],
        "schema" | "completions" => {
            &[(Exit::Success, "printed"), (Exit::Invalid, "wrong usage"), (Exit::Unfinished, STDOUT)]
        }
        "man" => &[
            (Exit::Success, "printed or written"),
            (Exit::Invalid, "wrong usage, or a folder that cannot be written"),
            (Exit::Unfinished, FILE),
        ],
        _ => &[
            (Exit::Success, "all runs finished, every expectation and claim held"),
            (Exit::Failed, "an expectation did not hold, or a claim fails"),
            (
                Exit::Invalid,
                "wrong usage, or a scenario, robot or filter is invalid, or the folder of results or the address of --live \
                 cannot be used; nothing was run",
            ),
            (
                Exit::Unfinished,
                "a run or a reference run did not finish (diverged, stalled, timed out, ended by an error), or results or \
                 standard output could not be written to the end",
            ),
            (Exit::Nothing, NOTHING),
            (Exit::Undecided, UNDECIDED),
            (Exit::Interrupted, "interrupted by Ctrl-C (SIGINT); finished runs are kept"),
            (Exit::Terminated, "interrupted by SIGTERM; finished runs are kept"),
        ],
    }
}

/// Width of help texts, columns.
const WIDTH: usize = 80;

/// Text below the help of a command.
pub fn help(command: &str) -> String {
    let mut out = "Exit codes:".to_owned();
    for (exit, meaning) in codes(command) {
        out += &format!("\n  {:<4}", *exit as u8);
        let mut column = 6;
        for word in meaning.split(' ') {
            if column + 1 + word.len() > WIDTH {
                out += "\n      ";
                column = 6;
            }
            out += " ";
            out += word;
            column += 1 + word.len();
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[derive(Debug, thiserror::Error)]
    #[error("outer")]
    struct Outer(#[source] io::Error);

    #[test]
    fn the_exit_code_of_a_batch() {
        let cases = [
            (None, [false, false, false], Exit::Success),
            (None, [false, true, false], Exit::Failed),
            (None, [true, false, false], Exit::Unfinished),
            (None, [true, true, true], Exit::Unfinished),
            (None, [false, true, true], Exit::Failed),
            (None, [false, false, true], Exit::Undecided),
            (Some(Exit::Interrupted), [false, false, true], Exit::Interrupted),
            (Some(Exit::Interrupted), [true, true, false], Exit::Interrupted),
            (Some(Exit::Terminated), [false, true, false], Exit::Terminated),
        ];
        for (interrupted, [unfinished, failed, undecided], exit) in cases {
            let ending = Ending { interrupted, unfinished, failed, undecided };
            assert_eq!(Exit::of_ending(ending), exit, "{ending:?}");
        }
    }

    #[test]
    fn a_place_that_is_wrong_and_a_disk_that_is_full() {
        assert_eq!(Exit::of_writing(&io::Error::from(ErrorKind::NotADirectory)), Exit::Invalid);
        assert_eq!(Exit::of_writing(&Outer(ErrorKind::PermissionDenied.into())), Exit::Invalid);
        assert_eq!(Exit::of_writing(&Outer(ErrorKind::StorageFull.into())), Exit::Unfinished);
        assert_eq!(Exit::of_writing(&io::Error::other("?")), Exit::Unfinished);
    }
}
