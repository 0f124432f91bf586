//! Runs the parsers on mutated files of the repository. Mutations replace tokens by others of the
//! file or by edge cases, delete, duplicate and move lines, and change characters. They are
//! deterministic.

use super::targets::{self, tree};
use super::{Take, files};

/// Mutated copies of each seed.
const COPIES: u64 = 6;

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
struct Stream(u64);

impl Stream {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
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

fn mutated(text: &str, stream: &mut Stream) -> String {
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

/// Runs a target on mutated copies of all files with this extension in folders of the repository;
/// each letter is a prefix that selects the kind of input.
fn check(target: Take, folders: &[&str], ending: &str, letters: &str) {
    let mut folders: Vec<_> = folders.iter().map(|folder| tree::root().join(folder)).collect();
    let mut seeds = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in files(&folder) {
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(found) if found == ending => seeds.push(path),
                _ => {}
            }
        }
    }
    assert!(!seeds.is_empty(), "no {ending}");
    seeds.sort();
    for (number, path) in seeds.iter().enumerate() {
        let text = std::fs::read_to_string(path).unwrap();
        for copy in 0..COPIES {
            let mut stream = Stream(1000 * number as u64 + copy);
            let mutated = mutated(&text, &mut stream);
            // Printed if the test panics.
            println!("{} mutated, copy {copy}:\n{mutated}", path.display());
            if letters.is_empty() {
                target(mutated.as_bytes());
            }
            letters.chars().for_each(|letter| target(format!("{letter}{mutated}").as_bytes()));
        }
    }
}

#[test]
fn nearly_valid_scenarios_do_not_panic() {
    check(targets::scenario::take, &["scenarios", "tests/scenario"], "toml", "");
}

#[test]
fn nearly_valid_robot_files_do_not_panic() {
    check(targets::robot_file::take, &["robots"], "toml", "");
}

#[test]
fn nearly_valid_urdfs_do_not_panic() {
    check(targets::urdf::take, &["robots", "scenarios"], "urdf", "");
}

#[test]
fn nearly_valid_motions_do_not_panic() {
    check(targets::motion::take, &["scenarios/motions"], "toml", "p");
    check(targets::motion::take, &["scenarios/motions"], "csv", "clm");
    check(targets::motion::take, &["scenarios/motions"], "bvh", "b");
}

#[test]
fn nearly_valid_scripts_do_not_panic() {
    check(targets::script::take, &["scenarios"], "luau", "tTHfF");
}

#[test]
fn nearly_valid_meshes_do_not_panic() {
    check(targets::mesh::take, &["fuzz/seeds/mesh"], "obj", "o");
    check(targets::mesh::take, &["fuzz/seeds/mesh"], "dae", "d");
}

#[test]
fn nearly_valid_packets_do_not_panic() {
    let mut stream = Stream(1);
    for kind in targets::wire::KINDS {
        for tag in targets::wire::TAGS {
            for copy in 0..200 {
                let mut packet = vec![kind, tag, if copy % 4 == 0 { stream.next() as u8 } else { 0 }];
                for _ in 0..stream.below(4) {
                    // Half of the offsets fall into the header and the sizes.
                    let end = if stream.below(2) == 0 { 64 } else { 1024 };
                    packet.extend_from_slice(&(stream.below(end) as u16).to_le_bytes());
                    packet.push(stream.next() as u8);
                }
                targets::wire::take(&packet);
            }
        }
    }
}
