//! Parses XML; positions of elements and of syntax errors.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::xml_attributes::{MAX_ATTRIBUTES, excess_attribute};

/// A text that is not well-formed, or exceeds a limit.
pub struct XmlError {
    /// The bytes concerned.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
}

/// Parses a text.
///
/// # Errors
/// A text that is not well-formed; an element with too many attributes.
pub fn parse(text: &str) -> Result<Document<'_>, XmlError> {
    if let Some(at) = excess_attribute(text) {
        let message = format!("an element has more than {MAX_ATTRIBUTES} attributes");
        return Err(XmlError { span: at..at + 1, message });
    }
    Document::parse(text).map_err(|error| syntax_error(text, &error))
}

fn syntax_error(text: &str, error: &roxmltree::Error) -> XmlError {
    let position = error.pos();
    let lines = text.split_inclusive('\n');
    let line_start: usize = lines.take(position.row.saturating_sub(1) as usize).map(str::len).sum();
    let line = text[line_start..].lines().next().unwrap_or("");
    let column = line.char_indices().nth(position.col.saturating_sub(1) as usize).map_or(line.len(), |(i, _)| i);
    let start = line_start + column;
    let message = error.to_string();
    // The parser repeats the position at the end of its sentence.
    let sentence = message.rsplit_once(" at ").map_or(message.as_str(), |(sentence, _)| sentence);
    XmlError { span: start..start + 1, message: format!("the XML is not well-formed: {sentence}") }
}

/// Position and name of the root element: the first one after declarations and comments.
pub fn root_tag(text: &str) -> Option<(usize, &str)> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        if rest.starts_with("<!--") {
            at += rest.find("-->")?;
        } else if rest.starts_with("<?") || rest.starts_with("<!") {
            at += 1;
        } else {
            let name = rest[1..].split(|c: char| c.is_whitespace() || c == '>' || c == '/').next()?;
            return Some((at, name));
        }
    }
}

/// The bytes of an element's opening tag; the element may span hundreds of lines.
pub fn open_tag(text: &str, node: Node) -> Range<usize> {
    let range = node.range();
    let after_attributes = node.attributes().map(|a| a.range().end).max().unwrap_or(range.start);
    let end = text[after_attributes..range.end].find('>').map_or(range.end, |i| after_attributes + i + 1);
    range.start..end
}
