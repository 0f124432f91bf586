//! The text of one input file and places in it.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::{Fault, RobotError};

/// A file read as text, cheap to clone, able to turn byte offsets into lines and columns.
#[derive(Clone, Debug)]
pub struct Source {
    path: PathBuf,
    text: Arc<str>,
}

impl Source {
    /// Reads a file; [`RobotError::Read`] when it cannot be opened or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| RobotError::Read { path: path.to_owned(), reason: source.to_string() })?;
        Ok(Self { path: path.to_owned(), text: text.into() })
    }

    /// The path as it was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Line and column of a byte offset, both counted from 1; columns count characters.
    pub fn position(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.text[..end];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Line of a byte offset, counted from 1.
    pub fn line(&self, offset: usize) -> usize {
        self.position(offset).0
    }

    /// A fault at `span`; fill in what was seen and wanted with the builder methods of [`Fault`].
    pub fn fault(&self, span: Range<usize>, message: impl Into<String>) -> Fault {
        Fault::new(self.clone(), span, message.into())
    }
}
