//! XML files of robots: syntax errors as errors of a robot, and the root element.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::robot_error::{FileError, RobotError};
use crate::text::source::Source;
use crate::text::xml_syntax::{self, root_tag};

/// Parses a file. Errors have their position.
pub(super) fn parse(source: &Source) -> Result<Document<'_>, RobotError> {
    xml_syntax::parse(source.text()).map_err(|error| FileError::new(source, error.span, error.message).syntax())
}

/// The bytes of an element's opening tag.
pub(super) fn open_tag(source: &Source, node: Node) -> Range<usize> {
    xml_syntax::open_tag(source.text(), node)
}

/// Byte of the root element, for notices about a whole file; 0 if there is none.
pub(super) fn root_element(source: &Source) -> usize {
    root_tag(source.text()).map_or(0, |(at, _)| at)
}
