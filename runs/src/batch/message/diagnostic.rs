//! Converts findings to messages.

use super::DiagnosticMessage;
use crate::batch::Finding;
use crate::robot::RobotError;
use crate::text::Diagnostic;

impl From<&Finding> for DiagnosticMessage {
    fn from(finding: &Finding) -> Self {
        let about = match finding {
            Finding::Scenario(diagnostic) => of_diagnostic(diagnostic),
            Finding::Robot { error, .. } => of_robot(error),
            Finding::Notice(notice) => of_notice(notice),
            Finding::Plan(message) => DiagnosticMessage { message: message.clone(), ..Self::default() },
        };
        DiagnosticMessage { severity: finding.severity().name(), rendered: finding.render(false), ..about }
    }
}

fn of_diagnostic(diagnostic: &Diagnostic) -> DiagnosticMessage {
    DiagnosticMessage {
        message: diagnostic.message.clone(),
        file: Some(diagnostic.file.clone()).filter(|file| !file.is_empty()),
        line: diagnostic.position.map(|position| position.line),
        column: diagnostic.position.map(|position| position.column),
        // The text of a filter has no keys, though it may read like TOML.
        key: if diagnostic.file == "--filter" { None } else { diagnostic.key() },
        help: diagnostic.help.clone(),
        ..DiagnosticMessage::default()
    }
}

fn of_robot(error: &RobotError) -> DiagnosticMessage {
    let message = of_diagnostic(&error.diagnostic());
    // An error of the robot file's TOML parser has the key at its position.
    match error.file_error().map(|error| error.element.as_str()) {
        None | Some("robot file") => message,
        Some(element) => DiagnosticMessage { key: Some(element.to_owned()).filter(|key| !key.is_empty()), ..message },
    }
}

fn of_notice(notice: &Diagnostic) -> DiagnosticMessage {
    DiagnosticMessage { column: None, key: None, ..of_diagnostic(notice) }
}
