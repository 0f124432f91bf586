//! Inputs found by fuzzing no longer fail, and nearly valid files give an error, not a panic.
//!
//! Both use the functions that the fuzz targets call (`fuzz/src`).

mod large;
mod mutation;
mod nearly_valid;
#[path = "../../fuzz/src/lib.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

type Take = fn(&[u8]);

/// The targets by the names of their folders.
const TARGETS: &[(&str, Take)] = &[
    ("scenario", targets::scenario::take),
    ("robot_file", targets::robot_file::take),
    ("urdf", targets::urdf::take),
    ("mjcf", targets::mjcf::take),
    ("sdf", targets::sdf::take),
    ("world", targets::world::take),
    ("fit", targets::fit::take),
    ("motion", targets::motion::take),
    ("script", targets::script::take),
    ("mesh", targets::mesh::take),
    ("terrain", targets::terrain::take),
    ("wire", targets::wire::take),
    ("results", targets::results::take),
    ("log", targets::log::take),
    ("http", targets::http::take),
    ("live", targets::live::take),
    ("filter", targets::filter::take),
    ("console", targets::console::take),
];

/// Longest time for one input; the same as the timeout of a fuzz target.
const TIMEOUT: Duration = Duration::from_secs(10);

fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn fuzzing_findings_stay_fixed() {
    let regressions = targets::tree::root().join("tests/fuzz_regressions");
    for folder in files(&regressions) {
        let name = folder.file_name().unwrap().to_str().unwrap();
        assert!(name == "live" || TARGETS.iter().any(|(target, _)| *target == name), "{name} is no target");
    }
    for (target, take) in TARGETS {
        for file in files(&regressions.join(target)) {
            // Printed if the test panics.
            println!("{}", file.display());
            let start = Instant::now();
            take(&std::fs::read(&file).unwrap());
            assert!(start.elapsed() < TIMEOUT, "{} takes {:?}", file.display(), start.elapsed());
        }
    }
}
