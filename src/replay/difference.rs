//! A difference between a run and its re-run.

use std::fmt;

/// The first difference of a file.
#[derive(Clone, PartialEq, Debug)]
pub struct Difference {
    /// The file.
    pub file: &'static str,
    /// Its position in the file: time and column, or the path of a value.
    pub position: String,
    /// The recorded value and the value of the re-run, if they are short texts.
    pub values: Option<(String, String)>,
    /// Number of other values that differ.
    pub more: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Difference { file, position, values, more } = self;
        write!(f, "{file}: {position}")?;
        if let Some((then, now)) = values {
            write!(f, ": {then} then, {now} now")?;
        }
        match more {
            0 => Ok(()),
            1 => write!(f, " (and 1 more value)"),
            n => write!(f, " (and {n} more values)"),
        }
    }
}
