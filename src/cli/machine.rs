//! Output for other programs: JUnit XML, and JSON messages on standard output.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use stiction::batch::{BatchError, DiagnosticMessage, Findings, Junit, Message, Options, Plan};

use super::Exit;
use super::terminal::print;

/// What standard output holds.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum MessageFormat {
    /// What people read
    Human,
    /// A JSON object per line and nothing else: see docs/ci.md and `runner schema messages`
    Json,
}

impl MessageFormat {
    /// Prints a message, if messages are enabled.
    pub fn tell(self, message: Message) -> Result<(), Exit> {
        match self {
            MessageFormat::Human => Ok(()),
            MessageFormat::Json => print(&message.line()),
        }
    }

    /// Prints findings as messages, if messages are enabled.
    pub fn tell_findings(self, findings: &Findings) -> Result<(), Exit> {
        // Rendering them may take long.
        if self == MessageFormat::Human {
            return Ok(());
        }
        findings.iter().map(DiagnosticMessage::from).try_for_each(|finding| self.tell(Message::Diagnostic(finding)))
    }
}

/// Arguments of commands that tell what they do.
#[derive(Args, Debug)]
pub struct Format {
    /// What standard output holds
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = MessageFormat::Human)]
    pub message_format: MessageFormat,
}

/// Where test results go.
#[derive(Args, Debug)]
pub struct TestResults {
    /// Write what became of every run as JUnit XML, also when interrupted
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    junit: Option<PathBuf>,
}

impl TestResults {
    /// Listener that writes test results, if requested.
    pub fn listener(&self, plan: &Plan, options: &Options) -> Result<Option<Junit>, BatchError> {
        self.junit.as_deref().map(|path| Junit::new(path, plan, &options.output, options.slow)).transpose()
    }
}
