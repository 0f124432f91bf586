//! Errors of scripts, with file and line.

use std::fmt;

/// File, line if known, and message. Shown as `file:line: message`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ScriptError {
    /// The script as the scenario names it.
    pub file: String,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
}

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

impl ScriptError {
    /// An error in `file`.
    pub fn new(file: &str, line: Option<usize>, message: impl Into<String>) -> Self {
        ScriptError { file: file.to_owned(), line, message: message.into() }
    }

    /// Reads an error of the interpreter in the script `file`: a message that begins with its
    /// location, then a traceback.
    pub(super) fn read(file: &str, error: &mlua::Error) -> Self {
        let report = match error {
            mlua::Error::CallbackError { cause, .. } => return Self::read(file, cause),
            mlua::Error::RuntimeError(text) | mlua::Error::SyntaxError { message: text, .. } => text.clone(),
            mlua::Error::MemoryError(_) => return Self::new(file, None, super::sandbox::out_of_memory()),
            other => other.to_string(),
        };
        let (text, trace) = report.split_once("\nstack traceback:").unwrap_or((&report, ""));
        let text = text.trim_end();
        // The script's line in the traceback, for messages of library functions and of the prelude.
        let script_line = |line: &str| {
            let digits =
                line.trim().strip_prefix(file)?.strip_prefix(':')?.split(|c: char| !c.is_ascii_digit()).next()?;
            digits.parse().ok()
        };
        let caller = || trace.lines().find_map(script_line);
        if let Some((_, message)) = text.strip_prefix("prelude:").and_then(|rest| rest.split_once(": ")) {
            return Self::new(file, caller(), message);
        }
        let located = text.strip_prefix(file).and_then(|rest| rest.strip_prefix(':'));
        let split = located.and_then(|rest| rest.split_once(':'));
        match split.map(|(line, message)| (line.parse().ok(), message)) {
            Some((line @ Some(_), message)) => Self::new(file, line, message.trim_start()),
            _ if text.contains("not enough memory") => Self::new(file, None, super::sandbox::out_of_memory()),
            _ => Self::new(file, caller(), text),
        }
    }
}
