//! Hashes of the files that a run reads.

use std::path::Path;

use crate::batch::Job;
use crate::results::{InputHash, hash_input};

/// Hashes of the files that the scenario names and of the robot's, named relative to its folder.
pub(in crate::batch) fn input_hashes(job: &Job) -> Vec<InputHash> {
    let home = job.robot.files.first().and_then(|(path, _)| path.parent()).unwrap_or(Path::new(""));
    let name = |path: &Path| match path.strip_prefix(home) {
        Ok(below) => below.display().to_string(),
        Err(_) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    };
    let robot = job.robot.files.iter().map(|(path, bytes)| hash_input(&name(path), bytes));
    robot.chain(job.run.inputs.iter().map(|input| hash_input(&input.name(), &input.bytes))).collect()
}
