//! Runs programs of an engine with a list of arguments, without a shell.

use std::process::{Command, ExitStatus};

use super::{SubmitError, quoting};

/// Exit status and output of a program.
pub(super) struct CommandOutput {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

/// A program of an engine with its arguments.
pub(super) struct EngineCommand {
    pub engine: &'static str,
    pub program: &'static str,
    pub arguments: Vec<String>,
}

impl EngineCommand {
    /// The command as text for a shell.
    pub fn as_text(&self) -> String {
        format!("{} {}", self.program, quoting::command(&self.arguments))
    }

    pub fn command(&self) -> Command {
        let mut command = Command::new(self.program);
        command.args(&self.arguments).stdin(std::process::Stdio::null());
        command
    }

    pub fn not_found(&self, source: std::io::Error) -> SubmitError {
        SubmitError::NotFound { program: self.program, engine: self.engine, source }
    }

    /// Runs the program until it exits.
    pub fn run(&self) -> Result<CommandOutput, SubmitError> {
        let output = self.command().output().map_err(|source| self.not_found(source))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        Ok(CommandOutput { status: output.status, stdout: text(&output.stdout), stderr: text(&output.stderr) })
    }

    /// Runs the program; an exit code other than 0 is an error. `remaining` names the jobs that
    /// remain then.
    pub fn run_checked(&self, remaining: &str) -> Result<CommandOutput, SubmitError> {
        let output = self.run()?;
        match output.status.success() {
            true => Ok(output),
            false => Err(self.refused(&output.status, &output.stderr, remaining)),
        }
    }

    pub fn refused(&self, status: &ExitStatus, output: &str, remaining: &str) -> SubmitError {
        SubmitError::Refused {
            engine: self.engine,
            command: self.as_text(),
            status: status_text(status),
            output: output.to_owned(),
            remaining: remaining.to_owned(),
        }
    }
}

/// An exit status as text: `exit code 1`, or the signal.
pub(super) fn status_text(status: &ExitStatus) -> String {
    status.code().map_or_else(|| status.to_string(), |code| format!("exit code {code}"))
}
