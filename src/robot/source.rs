//! The text of one input file and places in it.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::files::input;

use super::error::{Fault, RobotError};

/// A file read as text, cheap to clone, able to turn byte offsets into lines and columns.
#[derive(Clone, Debug)]
pub struct Source {
    path: PathBuf,
    text: Arc<str>,
    /// Byte offsets at which lines begin, ascending from 0.
    lines: Arc<[usize]>,
}

impl Source {
    /// Reads a file; [`RobotError::Read`] when it cannot be opened or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        let text = input::read_text(path, input::MOST_TEXT)
            .map_err(|source| RobotError::Read { path: path.to_owned(), reason: source.to_string() })?;
        Ok(Self::of(path, text))
    }

    /// A text that is at hand; `path` is what it is called.
    pub fn of(path: &Path, text: String) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        Self { path: path.to_owned(), text: text.into(), lines }
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
        let line = self.lines.partition_point(|start| *start <= end);
        (line, self.text[self.lines[line - 1]..end].chars().count() + 1)
    }

    /// Line of a byte offset, counted from 1.
    pub fn line(&self, offset: usize) -> usize {
        self.lines.partition_point(|start| *start <= offset.min(self.text.len()))
    }

    /// A fault at `span`; fill in what was seen and wanted with the builder methods of [`Fault`].
    pub fn fault(&self, span: Range<usize>, message: impl Into<String>) -> Fault {
        Fault::new(self.clone(), span, message.into())
    }
}
