//! Names by pattern, as shells have it.

/// Does a name match a pattern, in which `*` stands for any characters and `?` for one.
pub(crate) fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // Where the last star stands, and up to where it reaches.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        if p < pattern.len() && pattern[p] == '*' {
            star = Some((p, n));
            p += 1;
        } else if p < pattern.len() && (pattern[p] == '?' || pattern[p] == name[n]) {
            (p, n) = (p + 1, n + 1);
        } else if let Some((at, reach)) = star {
            star = Some((at, reach + 1));
            (p, n) = (at + 1, reach + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_and_question_marks() {
        let yes = [
            ("*", "a.b"),
            ("", ""),
            ("a*", "a"),
            ("a*c", "abbc"),
            ("*.force_?_N", "sole.left.force_x_N"),
            ("a*b*c", "axxbxbxc"),
            ("?", "é"),
            ("a**", "a"),
            ("*b", "abab"),
        ];
        let no = [("", "a"), ("a", "ab"), ("a*c", "abcd"), ("?", ""), ("*.force_?_N", "force_x_N"), ("ab*ab", "ab")];
        assert!(yes.iter().all(|(p, n)| matches(p, n)));
        assert!(no.iter().all(|(p, n)| !matches(p, n)));
    }
}
