//! How text looks, as a person writes it.

use crate::export::{ExportError, Header, TextFormat, TimeUnit};

impl TextFormat {
    /// Sets an option by its name: `separator`, `numbers`, `header`, `comment`, `missing`, `time-unit`, `blocks`.
    ///
    /// # Errors
    /// In words: no such option, or no such value.
    pub fn set(&mut self, option: &str, value: &str) -> Result<(), String> {
        match option {
            "separator" => self.separator = separator(value)?,
            "numbers" => self.numbers = value.parse().map_err(|error: ExportError| error.to_string())?,
            "header" => {
                self.header = match value {
                    "plain" => Header::Plain,
                    "comment" => Header::Comment,
                    "none" => Header::None,
                    _ => return Err(format!("`header` must be plain, comment or none, not `{value}`")),
                }
            }
            "comment" => self.comment = visible(value)?,
            "missing" => self.missing = visible(value)?,
            "time-unit" => {
                self.time = match value {
                    "s" => TimeUnit::Seconds,
                    "ms" => TimeUnit::Milliseconds,
                    "min" => TimeUnit::Minutes,
                    _ => return Err(format!("`time-unit` must be s, ms or min, not `{value}`")),
                }
            }
            "blocks" => self.blocks = Some(value.to_owned()),
            _ => {
                return Err(format!(
                    "`{option}` is none of separator, numbers, header, comment, missing, time-unit, blocks"
                ));
            }
        }
        Ok(())
    }
}

/// What stands between two cells: a word for it, or the characters themselves.
///
/// # Errors
/// In words: it could not be told from what it separates.
pub fn separator(text: &str) -> Result<String, String> {
    match text {
        "space" => Ok(" ".into()),
        "tab" => Ok("\t".into()),
        "comma" => Ok(",".into()),
        "semicolon" => Ok(";".into()),
        "" => Err("empty".into()),
        _ if text
            .contains(|c: char| c == '\n' || c == '\r' || c == '"' || c.is_alphanumeric() || "+-.".contains(c)) =>
        {
            Err("it could be taken for a part of a cell or of a line".into())
        }
        _ => Ok(text.into()),
    }
}

/// A word that can stand in a cell.
///
/// # Errors
/// In words: it is empty, or has blanks or quotes.
pub fn visible(text: &str) -> Result<String, String> {
    let fine = !text.is_empty() && !text.contains(char::is_whitespace) && !text.contains('"');
    if fine { Ok(text.into()) } else { Err("neither empty nor with blanks or quotes".into()) }
}
