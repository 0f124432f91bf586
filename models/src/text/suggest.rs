//! Suggests the nearest known name: "did you mean".

/// The known name nearest to `word`, if one is close enough.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let folded = word.to_lowercase().replace('_', "-");
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&folded, &k.to_lowercase().replace('_', "-")), k))
        // A third of the letters may differ, and at least one.
        .filter(|(distance, k)| *distance <= (word.chars().count().max(k.chars().count()) / 3).max(1))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}

/// A help line: the nearest known name, or all of them when none is close.
pub fn help<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    if let Some(near) = nearest(word, known.clone()) {
        return format!("did you mean `{near}`?");
    }
    let all: Vec<_> = known.into_iter().map(|k| format!("`{k}`")).collect();
    match all.len() {
        0 => "there are none here".into(),
        1 => format!("only {} is known here", all[0]),
        _ => format!("known here: {}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_found_and_far_ones_are_not() {
        let known = ["friction", "height", "rpy"];
        assert_eq!(nearest("fricton", known), Some("friction"));
        assert_eq!(nearest("Height", known), Some("height"));
        assert_eq!(nearest("ryp", known), Some("rpy"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(nearest("joint_friction", ["joint-friction"]), Some("joint-friction"));
        assert_eq!(help("colour", known), "known here: `friction`, `height`, `rpy`");
    }
}
