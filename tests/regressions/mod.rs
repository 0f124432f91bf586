//! Findings of fuzzing stay fixed, and nearly valid files give an error, not a panic.
//!
//! Both go through the very functions that the fuzz targets call (`fuzz/src`).

mod large;
mod mutation;
#[path = "../../fuzz/src/lib.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

type Take = fn(&[u8]);

/// The targets by the names of their folders.
const TARGETS: [(&str, Take); 7] = [
    ("scenario", targets::scenario::take),
    ("robot_file", targets::robot_file::take),
    ("urdf", targets::urdf::take),
    ("motion", targets::motion::take),
    ("script", targets::script::take),
    ("mesh", targets::mesh::take),
    ("wire", targets::wire::take),
];

/// What took longer was a finding of its own; a fuzz target is given as long.
const PATIENCE: Duration = Duration::from_secs(10);

fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn what_fuzzing_found_is_mended() {
    let kept = targets::tree::root().join("tests/fuzz_regressions");
    for folder in files(&kept) {
        let name = folder.file_name().unwrap().to_str().unwrap();
        assert!(TARGETS.iter().any(|(target, _)| *target == name), "{name} is no target");
    }
    for (target, take) in TARGETS {
        for file in files(&kept.join(target)) {
            // Shown if it panics.
            println!("{}", file.display());
            let start = Instant::now();
            take(&std::fs::read(&file).unwrap());
            assert!(start.elapsed() < PATIENCE, "{} takes {:?}", file.display(), start.elapsed());
        }
    }
}
