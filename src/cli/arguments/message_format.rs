//! Output for other programs: JUnit XML, and JSON messages on standard output.

use std::path::PathBuf;

use crate::batch::{BatchError, DiagnosticMessage, Findings, Junit, Message, Options, Plan};
use clap::{Args, ValueEnum, ValueHint};

use crate::cli::Exit;
use crate::cli::terminal::print;

/// Contents of standard output.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum MessageFormat {
    /// Text for people
    Human,
    /// One JSON object per line: see docs/ci.md and `runner schema messages`
    Json,
}

impl MessageFormat {
    /// Prints a message, if messages are enabled.
    pub fn emit(self, message: Message) -> Result<(), Exit> {
        match self {
            MessageFormat::Human => Ok(()),
            MessageFormat::Json => print(&message.line()),
        }
    }

    /// Prints findings as messages, if messages are enabled.
    pub fn emit_findings(self, findings: &Findings) -> Result<(), Exit> {
        // Rendering them may take long.
        if self == MessageFormat::Human {
            return Ok(());
        }
        findings.iter().map(DiagnosticMessage::from).try_for_each(|finding| self.emit(Message::Diagnostic(finding)))
    }
}

/// Arguments of commands that emit messages.
#[derive(Args, Debug)]
pub struct Format {
    /// Format of standard output
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = MessageFormat::Human)]
    pub message_format: MessageFormat,
}

/// Destination of test results.
#[derive(Args, Debug)]
pub struct TestResults {
    /// Write the outcome of every run as JUnit XML, even after an interruption
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    junit: Option<PathBuf>,
}

impl TestResults {
    /// Listener that writes test results, if requested.
    pub fn listener(&self, plan: &Plan, options: &Options) -> Result<Option<Junit>, BatchError> {
        self.junit.as_deref().map(|path| Junit::new(path, plan, &options.output, options.slow)).transpose()
    }
}
