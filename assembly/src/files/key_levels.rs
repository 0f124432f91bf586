//! Folders between that of a scenario and those of its runs, which keep folders small: file systems
//! and tools become slow with a million names in one.
//!
//! | runs of the scenario | folder of a run |
//! |---|---|
//! | at most 10 000 | `SCENARIO/KEY` |
//! | at most 1 000 000 | `SCENARIO/3f/KEY`, by the first two digits of the key |
//! | more | `SCENARIO/3f/5a/KEY`, by the first four |

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Greatest numbers of runs for no folder and for one folder in between.
const LIMITS: [usize; 2] = [10_000, 1_000_000];

/// Digits of the key in the name of a folder.
const DIGITS: usize = 2;

/// Number of folders between that of a scenario and those of its runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u8")]
pub struct KeyLevels(u8);

impl KeyLevels {
    /// For a scenario with this number of runs, those of all shards and before any filter.
    pub fn of(runs: usize) -> Self {
        KeyLevels(LIMITS.iter().filter(|limit| runs > **limit).count() as u8)
    }

    /// All that exist.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..=LIMITS.len() as u8).map(KeyLevels)
    }

    /// True without folders in between.
    pub fn is_none(&self) -> bool {
        self.0 == 0
    }

    /// The folder of the run with this key, below that of its scenario.
    pub fn folder(self, key: &str) -> PathBuf {
        let digits = (0..usize::from(self.0)).map_while(|level| key.get(level * DIGITS..(level + 1) * DIGITS));
        // Keys of a damaged list may be anything, such as `..name`.
        digits.take_while(|digits| digits.bytes().all(|byte| byte.is_ascii_hexdigit())).chain([key]).collect()
    }
}

impl TryFrom<u8> for KeyLevels {
    type Error = String;

    fn try_from(levels: u8) -> Result<Self, String> {
        KeyLevels::all()
            .find(|known| known.0 == levels)
            .ok_or_else(|| format!("{levels} levels of folders are unknown"))
    }
}

/// Folders of runs in the folder of a scenario, in all layouts, relative to it.
pub fn run_folders(scenario: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut add = |below: PathBuf, levels: usize, left: &mut Vec<(PathBuf, usize)>| {
        let entries = std::fs::read_dir(scenario.join(&below)).into_iter().flatten().flatten();
        for entry in entries {
            let path = below.join(entry.file_name());
            match levels < LIMITS.len() && entry.file_name().len() == DIGITS {
                true => left.push((path, levels + 1)),
                false => found.push(path),
            }
        }
    };
    let mut left = vec![(PathBuf::new(), 0)];
    while let Some((below, levels)) = left.pop() {
        add(below, levels, &mut left);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_follow_the_number_of_runs() {
        let folder = |runs| KeyLevels::of(runs).folder("3f5ac1d2e4b60789").display().to_string();
        for (runs, expected) in [
            (1, "3f5ac1d2e4b60789"),
            (10_000, "3f5ac1d2e4b60789"),
            (10_001, "3f/3f5ac1d2e4b60789"),
            (1_000_000, "3f/3f5ac1d2e4b60789"),
            (1_000_001, "3f/5a/3f5ac1d2e4b60789"),
        ] {
            assert_eq!(folder(runs), expected, "{runs}");
        }
        for key in ["", "a", "äöü", "..ab"] {
            assert_eq!(KeyLevels(2).folder(key), Path::new(key));
        }
    }

    #[test]
    fn run_folders_are_found_in_all_layouts() {
        let scenario = tempfile::tempdir().unwrap();
        let mut expected: Vec<PathBuf> = KeyLevels::all().map(|levels| levels.folder("3f5ac1d2e4b60789")).collect();
        expected.iter().for_each(|folder| std::fs::create_dir_all(scenario.path().join(folder)).unwrap());
        let mut found = run_folders(scenario.path());
        found.sort();
        expected.sort();
        assert_eq!(found, expected);
        assert!(run_folders(&scenario.path().join("none")).is_empty());
    }
}
