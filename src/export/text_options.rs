//! Options of the text format, by name and value as typed by a user.

use crate::export::number_format::NumberFormatError;
use crate::export::text_format::{HeaderStyle, TextFormat, TimeUnit};

/// Why an option of the text format is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextOptionError {
    /// No such option.
    #[error("`{0}` is none of separator, numbers, header, comment, missing, time-unit, blocks")]
    UnknownOption(String),
    /// No such style of the header.
    #[error("`header` must be plain, comment or none, not `{0}`")]
    Header(String),
    /// No such unit.
    #[error("`time-unit` must be s, ms or min, not `{0}`")]
    TimeUnit(String),
    /// No such format of numbers.
    #[error(transparent)]
    Numbers(#[from] NumberFormatError),
    /// The separator is empty.
    #[error("empty")]
    EmptySeparator,
    /// The separator could be part of a cell.
    #[error("it could be part of a cell or end a line")]
    AmbiguousSeparator,
    /// The text does not fit into one cell.
    #[error("must not be empty and must not contain blanks or quotes")]
    NotOneCell,
}

impl TextFormat {
    /// Sets an option by its name: `separator`, `numbers`, `header`, `comment`, `missing`,
    /// `time-unit`, `blocks`.
    ///
    /// # Errors
    /// No such option, or a value that it does not accept.
    pub fn set(&mut self, option: &str, value: &str) -> Result<(), TextOptionError> {
        match option {
            "separator" => self.separator = separator(value)?,
            "numbers" => self.numbers = value.parse()?,
            "header" => {
                self.header = match value {
                    "plain" => HeaderStyle::Plain,
                    "comment" => HeaderStyle::Comment,
                    "none" => HeaderStyle::None,
                    _ => return Err(TextOptionError::Header(value.to_owned())),
                }
            }
            "comment" => self.comment = visible(value)?,
            "missing" => self.missing = visible(value)?,
            "time-unit" => {
                self.time = match value {
                    "s" => TimeUnit::Seconds,
                    "ms" => TimeUnit::Milliseconds,
                    "min" => TimeUnit::Minutes,
                    _ => return Err(TextOptionError::TimeUnit(value.to_owned())),
                }
            }
            "blocks" => self.blocks = Some(value.to_owned()),
            _ => return Err(TextOptionError::UnknownOption(option.to_owned())),
        }
        Ok(())
    }
}

/// Parses a separator of cells: one of four names, or the characters themselves.
///
/// # Errors
/// It is empty, or could be part of a cell.
pub fn separator(text: &str) -> Result<String, TextOptionError> {
    let ambiguous = |c: char| c == '\n' || c == '\r' || c == '"' || c.is_alphanumeric() || "+-.".contains(c);
    match text {
        "space" => Ok(" ".into()),
        "tab" => Ok("\t".into()),
        "comma" => Ok(",".into()),
        "semicolon" => Ok(";".into()),
        "" => Err(TextOptionError::EmptySeparator),
        _ if text.contains(ambiguous) => Err(TextOptionError::AmbiguousSeparator),
        _ => Ok(text.into()),
    }
}

/// Parses a text that fits into one cell.
///
/// # Errors
/// It is empty, or contains blanks or quotes.
pub fn visible(text: &str) -> Result<String, TextOptionError> {
    let fits = !text.is_empty() && !text.contains(char::is_whitespace) && !text.contains('"');
    if fits { Ok(text.into()) } else { Err(TextOptionError::NotOneCell) }
}
