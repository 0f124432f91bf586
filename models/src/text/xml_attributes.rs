//! Limits the attributes of XML elements before a parser reads them.

/// Greatest number of attributes of an element: the parser compares all pairs.
pub const MAX_ATTRIBUTES: usize = 1000;

/// The byte at which an element exceeds [`MAX_ATTRIBUTES`]. Text between two elements counts as
/// part of the first.
pub fn excess_attribute(text: &str) -> Option<usize> {
    let (mut count, mut is_given) = (0, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'<' => count = 0,
            b'"' | b'\'' if is_given => count += 1,
            _ => {}
        }
        is_given = byte == b'=' || is_given && byte.is_ascii_whitespace();
        if count > MAX_ATTRIBUTES {
            return Some(at);
        }
    }
    None
}
