//! Checksums inside JSON objects: their last member, `checksum`, is the BLAKE3 hash of the text
//! without it. Any changed bit of the text is detected.
//!
//! Objects without a checksum, which earlier versions wrote, are accepted.

/// Name of the member.
pub const MEMBER: &str = "checksum";

/// Layout of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Indented by two spaces; the checksum has 64 digits.
    Pretty,
    /// On one line; the checksum has 16 digits.
    Line,
}

impl Layout {
    /// Text before the digits.
    fn before(self) -> &'static str {
        match self {
            Layout::Pretty => ",\n  \"checksum\": \"",
            Layout::Line => ",\"checksum\":\"",
        }
    }

    /// End of an object without the member.
    fn end(self) -> &'static str {
        match self {
            Layout::Pretty => "\n}",
            Layout::Line => "}",
        }
    }

    fn digits(self) -> usize {
        match self {
            Layout::Pretty => 64,
            Layout::Line => 16,
        }
    }

    fn hash(self, parts: [&[u8]; 2]) -> String {
        let mut hasher = blake3::Hasher::new();
        parts.into_iter().for_each(|part| {
            hasher.update(part);
        });
        let mut digits = hasher.finalize().to_hex().to_string();
        digits.truncate(self.digits());
        digits
    }
}

/// Adds the checksum to the text of an object with at least one member, without a final line break.
pub fn append(object: &mut Vec<u8>, layout: Layout) {
    let digits = layout.hash([object, b""]);
    object.truncate(object.len().saturating_sub(layout.end().len()));
    for part in [layout.before(), &digits, "\"", layout.end()] {
        object.extend_from_slice(part.as_bytes());
    }
}

/// True unless the object has a checksum of another text. A final line break does not count.
pub fn is_intact(object: &[u8], layout: Layout) -> bool {
    let object = object.strip_suffix(b"\n").unwrap_or(object);
    let (before, end) = (layout.before().as_bytes(), layout.end().as_bytes());
    let length = before.len() + layout.digits() + 1 + end.len();
    let Some(at) = object.len().checked_sub(length) else { return true };
    let (content, member) = object.split_at(at);
    match member.strip_prefix(before).and_then(|rest| rest.split_at_checked(layout.digits())) {
        Some((digits, rest)) => {
            rest.strip_prefix(b"\"") == Some(end) && layout.hash([content, end]).as_bytes() == digits
        }
        // No checksum, or one that another program has laid out differently.
        None => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRETTY: &str = "{\n  \"schema\": 1,\n  \"key\": \"ab\"\n}";
    const LINE: &str = r#"{"scenario":"s","key":"ab"}"#;

    fn objects() -> [(Layout, &'static str); 2] {
        [(Layout::Pretty, PRETTY), (Layout::Line, LINE)]
    }

    #[test]
    fn objects_with_a_checksum_are_valid_and_intact() {
        for (layout, text) in objects() {
            let mut object = text.as_bytes().to_vec();
            append(&mut object, layout);
            let read: serde_json::Map<String, serde_json::Value> = serde_json::from_slice(&object).unwrap();
            let digits = read[MEMBER].as_str().unwrap();
            assert_eq!(read.len(), 3);
            assert_eq!(digits, &blake3::hash(text.as_bytes()).to_hex()[..layout.digits()]);
            assert!(is_intact(&object, layout));
            object.push(b'\n');
            assert!(is_intact(&object, layout));
        }
    }

    #[test]
    fn every_changed_bit_of_content_or_digits_is_detected() {
        for (layout, text) in objects() {
            let mut object = text.as_bytes().to_vec();
            append(&mut object, layout);
            let member = object.len() - layout.end().len() - 1 - layout.digits() - layout.before().len();
            let digits = member + layout.before().len();
            for at in (0..member).chain(digits..object.len()) {
                for bit in 0..8 {
                    let mut damaged = object.clone();
                    damaged[at] ^= 1 << bit;
                    assert!(!is_intact(&damaged, layout), "bit {bit} of byte {at}");
                }
            }
        }
    }

    #[test]
    fn objects_of_earlier_versions_are_accepted() {
        for (layout, text) in objects() {
            assert!(is_intact(text.as_bytes(), layout));
        }
        assert!(is_intact(b"", Layout::Line) && is_intact(b"{}", Layout::Pretty));
    }
}
