//! Shortens long texts, such as an error message that a script built.

/// Greatest length of a message of a run, bytes.
pub const MAX_MESSAGE: usize = 4096;

/// Length of the end that is kept, bytes: it often states the time and the position.
const END: usize = 512;

/// Cuts the middle out of a text of more than [`MAX_MESSAGE`] bytes and states how much is left
/// out. Other texts are returned unchanged, without a copy.
pub fn limit_length(mut text: String) -> String {
    if text.len() <= MAX_MESSAGE {
        return text;
    }
    let end = text.ceil_char_boundary(text.len() - END);
    let begin = text.floor_char_boundary(MAX_MESSAGE - END - 64);
    let omitted = format!(" ... ({} bytes left out) ... ", end - begin);
    text.replace_range(begin..end, &omitted);
    text.shrink_to_fit();
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_lose_their_middle() {
        let long = format!("begin {} at 0.5 s", "\u{1d6fc}".repeat(1_000_000));
        let short = limit_length(long.clone());
        assert!(short.len() <= MAX_MESSAGE && short.capacity() <= MAX_MESSAGE, "{}", short.len());
        let (begin, rest) = short.split_once(" ... (").unwrap();
        let (omitted, end) = rest.split_once(" bytes left out) ... ").unwrap();
        assert!(long.starts_with(begin) && long.ends_with(end));
        assert!(short.ends_with(" at 0.5 s"));
        assert_eq!(begin.len() + omitted.parse::<usize>().unwrap() + end.len(), long.len());
    }

    #[test]
    fn texts_of_the_greatest_length_are_kept() {
        let text = "A".repeat(MAX_MESSAGE);
        assert_eq!(limit_length(text.clone()), text);
        assert!(limit_length("A".repeat(MAX_MESSAGE + 1)).len() < MAX_MESSAGE);
    }
}
