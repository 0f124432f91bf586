//! Programs of engines, started with their arguments as they are.

use std::process::{Command, ExitStatus};

use super::{SubmitError, text};

/// What a program answered.
pub(super) struct Answer {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

/// A program with its arguments.
pub(super) struct Tool {
    pub engine: &'static str,
    pub program: &'static str,
    pub arguments: Vec<String>,
}

impl Tool {
    /// As somebody would type it.
    pub fn typed(&self) -> String {
        format!("{} {}", self.program, text::command(&self.arguments))
    }

    pub fn command(&self) -> Command {
        let mut command = Command::new(self.program);
        command.args(&self.arguments).stdin(std::process::Stdio::null());
        command
    }

    pub fn absent(&self, source: std::io::Error) -> SubmitError {
        SubmitError::Absent { program: self.program, engine: self.engine, source }
    }

    /// Runs it to its end.
    pub fn run(&self) -> Result<Answer, SubmitError> {
        let output = self.command().output().map_err(|source| self.absent(source))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        Ok(Answer { status: output.status, stdout: text(&output.stdout), stderr: text(&output.stderr) })
    }

    /// Runs it; if it fails, the engine refuses. `left` says what it has nevertheless.
    pub fn accepted(&self, left: &str) -> Result<Answer, SubmitError> {
        let answer = self.run()?;
        match answer.status.success() {
            true => Ok(answer),
            false => Err(self.refused(&answer.status, &answer.stderr, left)),
        }
    }

    pub fn refused(&self, status: &ExitStatus, said: &str, left: &str) -> SubmitError {
        SubmitError::Refused {
            engine: self.engine,
            command: self.typed(),
            status: ended(status),
            said: said.to_owned(),
            left: left.to_owned(),
        }
    }
}

/// `exit code 1`, or the signal.
pub(super) fn ended(status: &ExitStatus) -> String {
    status.code().map_or_else(|| status.to_string(), |code| format!("exit code {code}"))
}
