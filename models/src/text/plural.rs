//! Formats counts with their nouns.

/// Such as `1 run` or `2 runs`.
pub fn plural(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}
