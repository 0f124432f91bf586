//! Quotes arguments for scripts, and refuses text that no line of a script can hold.

use std::path::Path;

use super::SubmitError;

/// Returns a path as text for one line of a script.
///
/// # Errors
/// It is not UTF-8, or has control characters.
pub(super) fn path<'a>(what: &'static str, path: &'a Path) -> Result<&'a str, SubmitError> {
    let wrong = |why| SubmitError::Text { what, why, text: path.display().to_string() };
    line(what, path.to_str().ok_or_else(|| wrong("bytes that are not UTF-8"))?)
}

/// Returns a text for one line of a script.
///
/// # Errors
/// It has control characters.
pub(super) fn line<'a>(what: &'static str, text: &'a str) -> Result<&'a str, SubmitError> {
    match text.chars().find(|c| c.is_control()) {
        None => Ok(text),
        Some(c) => {
            let why = if matches!(c, '\n' | '\r') { "a line break" } else { "a control character" };
            Err(SubmitError::Text { what, why, text: text.to_owned() })
        }
    }
}

/// Quotes an argument for a POSIX shell. Within single quotes only the single quote is special.
pub(super) fn shell(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+:,@%".contains(c);
    match !argument.is_empty() && argument.chars().all(plain) {
        true => argument.to_owned(),
        false => format!("'{}'", argument.replace('\'', r"'\''")),
    }
}

/// Quotes the arguments of a command for a POSIX shell.
pub(super) fn command(arguments: &[String]) -> String {
    arguments.iter().map(|argument| shell(argument)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_back_quoted_arguments() {
        let arguments =
            ["", "plain", "two words", "it's", r#"a "b" \ $HOME `id` #x ~ * ! %a ünï"#, "-x=$(id)", "'", "''", "~"];
        let line = arguments.map(shell).join(" ");
        let output = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\n' {line}")]).output().unwrap();
        assert_eq!(
            String::from_utf8(output.stdout).unwrap(),
            arguments.map(|argument| format!("{argument}\n")).concat()
        );
    }

    #[test]
    fn control_characters_are_refused() {
        for text in ["a\nb", "a\rb", "a\u{1b}[1m", "\0"] {
            assert!(matches!(line("a text", text), Err(SubmitError::Text { .. })), "{text:?}");
        }
        assert_eq!(line("a text", "ünï \\ '").unwrap(), "ünï \\ '");
    }
}
