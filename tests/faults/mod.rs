//! Tests of batches that are killed, interrupted or out of disk space. In every case finished runs
//! are kept and all files are complete. `--resume` completes the results to those of an undisturbed
//! batch.

mod disk;
mod killed;
mod links;
mod readers;
mod resume;
mod special;
mod summary;

use std::path::Path;

use crate::cli::Place;
use crate::support::same::files;

/// Asserts that all files of a batch are complete. Unfinished files have the extension `.partial`.
#[track_caller]
pub fn assert_all_files_complete(results: &Path) {
    for file in files(results) {
        let path = results.join(&file);
        let bytes = || std::fs::read(&path).unwrap();
        match path.file_name().unwrap().to_str().unwrap() {
            "run.json" => {
                let record = stiction::results::RunRecord::read(&path).unwrap();
                assert_eq!(path.parent().unwrap().file_name().unwrap(), record.key.as_str());
            }
            "log.mcap" => {
                let log = bytes();
                let summary = mcap::Summary::read(&log).unwrap().expect("a log has a summary");
                assert!(summary.metadata_indexes.iter().any(|m| m.name == "end"), "{file}");
            }
            // Its last line may be incomplete. `--resume` removes it.
            "runs.jsonl" => {
                let text = String::from_utf8(bytes()).unwrap();
                for line in text.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
                    let line: serde_json::Value = serde_json::from_str(line).unwrap();
                    let field = |name: &str| line[name].as_str().unwrap().to_owned();
                    let record = results.join(field("scenario")).join(field("key")).join("run.json");
                    assert!(record.is_file(), "{} has a line and no record", record.display());
                }
            }
            "summary.csv" => assert!(bytes().ends_with(b"\n")),
            "summary.parquet" => assert!(bytes().ends_with(b"PAR1")),
            "report.html" => assert!(bytes().ends_with(b"</html>"), "{file}"),
            name => assert!(name.ends_with(".partial"), "{file} should not be there"),
        }
    }
}

/// Two scenarios with 16 runs and 4 references: impacts, sliding, sticking, logs, comparisons.
pub fn batch() -> Place {
    let place = Place::new();
    place.block(
        "thrown.toml",
        "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.3, 0] }
[sweep]
repeat = 2
[sweep.grid]
\"contact.method\" = [\"exact\", \"one-step\"]
\"floor.friction\" = [0.2, 0.5, 0.8]
",
    );
    place.block(
        "slides.toml",
        "base = { linear_velocity = [1, 0, 0] }
[compare]
reference = { \"integrator.relative_tolerance\" = 1e-9 }
[sweep.grid]
\"floor.friction\" = [0.2, 0.4]
\"integrator.method\" = [\"dopri5\", \"bs23\"]
",
    );
    place
}

/// Arguments for the runs of [`batch`].
pub const ARGUMENTS: [&str; 6] = ["thrown.toml", "slides.toml", "--set", "duration=0.5", "-j", "2"];

/// Exit code of the undisturbed batch.
pub const EXIT_CODE: i32 = 0;
