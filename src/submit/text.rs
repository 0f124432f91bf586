//! Words in scripts.

use std::path::Path;

use super::SubmitError;

/// A path as text that can stand on one line.
///
/// # Errors
/// It is no text, or has characters that end lines or command the terminal.
pub(super) fn path<'a>(what: &'static str, path: &'a Path) -> Result<&'a str, SubmitError> {
    let wrong = |why| SubmitError::Word { what, why, word: path.display().to_string() };
    line(what, path.to_str().ok_or_else(|| wrong("bytes that are no UTF-8"))?)
}

/// A word that can stand on one line.
///
/// # Errors
/// It has characters that end lines or command the terminal.
pub(super) fn line<'a>(what: &'static str, word: &'a str) -> Result<&'a str, SubmitError> {
    match word.chars().find(|c| c.is_control()) {
        None => Ok(word),
        Some(c) => {
            let why = if matches!(c, '\n' | '\r') { "a line break" } else { "a control character" };
            Err(SubmitError::Word { what, why, word: word.to_owned() })
        }
    }
}

/// A word for a POSIX shell: between single quotes nothing means anything but the single quote.
pub(super) fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+:,@%".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// Words for a POSIX shell.
pub(super) fn command(words: &[String]) -> String {
    words.iter().map(|word| shell(word)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_back_what_was_written() {
        let words =
            ["", "plain", "two words", "it's", r#"a "b" \ $HOME `id` #x ~ * ! %a ünï"#, "-x=$(id)", "'", "''", "~"];
        let line = words.map(shell).join(" ");
        let said = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\n' {line}")]).output().unwrap();
        assert_eq!(String::from_utf8(said.stdout).unwrap(), words.map(|word| format!("{word}\n")).concat());
    }

    #[test]
    fn what_would_break_a_line_is_refused() {
        for word in ["a\nb", "a\rb", "a\u{1b}[1m", "\0"] {
            assert!(matches!(line("a word", word), Err(SubmitError::Word { .. })), "{word:?}");
        }
        assert_eq!(line("a word", "ünï \\ '").unwrap(), "ünï \\ '");
    }
}
