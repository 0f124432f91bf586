//! Exit codes. They are API: scripts rely on them.

use std::process::{ExitCode, Termination};

/// Below the help of commands that run scenarios.
pub const HELP: &str = "Exit codes:
  0    all runs finished and every expectation held
  1    an expectation failed
  2    wrong usage, or a scenario or robot is invalid; nothing was run
  3    a run did not finish: diverged, stalled, timed out, crashed
  4    nothing selected
  130  interrupted; results so far are kept";

/// How the program ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Exit {
    /// All is well.
    Success = 0,
    /// An expectation did not hold.
    Failed = 1,
    /// Wrong usage or invalid input; nothing was run.
    Invalid = 2,
    /// A run did not finish.
    Unfinished = 3,
    /// There is nothing to do.
    Nothing = 4,
    /// Interrupted by a person.
    Interrupted = 130,
}

impl Termination for Exit {
    fn report(self) -> ExitCode {
        ExitCode::from(self as u8)
    }
}
