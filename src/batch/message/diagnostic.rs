//! Findings as messages.

use super::DiagnosticMessage;
use crate::batch::{Finding, Severity};
use crate::robot::{Notice, RobotError};
use crate::scenario::Diagnostic;

impl From<&Finding> for DiagnosticMessage {
    fn from(finding: &Finding) -> Self {
        let about = match finding {
            Finding::Scenario(diagnostic) => of_scenario(diagnostic),
            Finding::Robot { error, .. } => of_robot(error),
            Finding::Notice(notice) => of_notice(notice),
            Finding::Plan(message) => DiagnosticMessage { message: message.clone(), ..Self::default() },
        };
        let severity = match finding.severity() {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        DiagnosticMessage { severity, rendered: finding.render(false), ..about }
    }
}

fn of_scenario(diagnostic: &Diagnostic) -> DiagnosticMessage {
    DiagnosticMessage {
        message: diagnostic.message.clone(),
        file: Some(diagnostic.file.clone()).filter(|file| !file.is_empty()),
        line: diagnostic.place.map(|place| place.line),
        column: diagnostic.place.map(|place| place.column),
        // The text of a filter has no keys, though it may read like TOML.
        key: if diagnostic.file == "--filter" { None } else { diagnostic.key() },
        help: diagnostic.help.clone(),
        ..DiagnosticMessage::default()
    }
}

fn of_robot(error: &RobotError) -> DiagnosticMessage {
    let Some(fault) = error.fault() else {
        return DiagnosticMessage { message: error.to_string(), ..DiagnosticMessage::default() };
    };
    // What the parser of a robot file has found has a place, and there a key.
    let key = match fault.element.as_str() {
        "robot file" => Diagnostic::in_text("", fault.source.text(), fault.span.clone(), "", None).key(),
        element => Some(element.to_owned()),
    };
    DiagnosticMessage {
        message: fault.message.clone(),
        file: Some(fault.file().display().to_string()),
        line: Some(fault.line()),
        column: Some(fault.column()),
        key: key.filter(|element| !element.is_empty()),
        help: fault.help.clone(),
        ..DiagnosticMessage::default()
    }
}

fn of_notice(notice: &Notice) -> DiagnosticMessage {
    DiagnosticMessage {
        message: notice.message.clone(),
        file: Some(notice.file.display().to_string()),
        line: Some(notice.line),
        ..DiagnosticMessage::default()
    }
}
