//! Deterministic mutations of text and bytes. Those of text replace tokens by others of the text or
//! by edge cases, delete, duplicate and move lines, and change characters.

/// Edge cases that replace a token.
const EDGE_CASES: [&str; 18] = [
    "0",
    "-1",
    "1e308",
    "-1e-320",
    "nan",
    "inf",
    "4294967296",
    "9223372036854775807",
    "\"\"",
    "[]",
    "{}",
    "true",
    "\u{0}",
    "é",
    "..",
    "/",
    "&lt;",
    "[[",
];

/// SplitMix64: a seed gives the same stream on every machine.
pub struct Stream(pub u64);

impl Stream {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Byte ranges of tokens: runs of characters that occur in names and numbers.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let within = |c: char| c.is_alphanumeric() || "_.-".contains(c);
    let mut found = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (within(c), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                found.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    found
}

/// A text with one to three mutations.
pub fn mutated(text: &str, stream: &mut Stream) -> String {
    let mut text = text.to_owned();
    for _ in 0..1 + stream.below(3) {
        let tokens = tokens(&text);
        let mut lines: Vec<&str> = text.lines().collect();
        text = match stream.below(6) {
            0 | 1 if !tokens.is_empty() => {
                let (from, to) = tokens[stream.below(tokens.len())];
                format!("{}{}{}", &text[..from], EDGE_CASES[stream.below(EDGE_CASES.len())], &text[to..])
            }
            2 if !tokens.is_empty() => {
                let ((from, to), other) = (tokens[stream.below(tokens.len())], tokens[stream.below(tokens.len())]);
                format!("{}{}{}", &text[..from], &text[other.0..other.1], &text[to..])
            }
            3 if !lines.is_empty() => {
                lines.remove(stream.below(lines.len()));
                lines.join("\n")
            }
            4 if !lines.is_empty() => {
                let (from, to) = (stream.below(lines.len()), stream.below(lines.len()));
                lines.insert(to, lines[from]);
                lines.join("\n")
            }
            _ => {
                let at = stream.below(text.chars().count());
                let other = char::from(stream.below(128) as u8);
                text.chars().enumerate().map(|(i, c)| if i == at { other } else { c }).collect()
            }
        };
    }
    text
}

/// Bytes with one to four mutations: changed bits and bytes, edge cases of lengths, removed and
/// repeated pieces, a cut end.
pub fn mutated_bytes(bytes: &[u8], stream: &mut Stream) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + stream.below(4) {
        let at = stream.below(bytes.len());
        let end = bytes.len().min(at + 1 + stream.below(16));
        match stream.below(7) {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << stream.below(8)),
            1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = stream.next() as u8),
            2 => {
                let edge = [0, 1, 0x7f, 0x80, 0xff][stream.below(5)];
                bytes[at..end].fill(edge);
            }
            3 => drop(bytes.drain(at..end)),
            4 => bytes.extend_from_within(at..end),
            5 => {
                let piece = bytes[at..end].to_vec();
                let to = stream.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            _ => bytes.truncate(bytes.len() - stream.below(bytes.len().min(64))),
        }
    }
    bytes
}
