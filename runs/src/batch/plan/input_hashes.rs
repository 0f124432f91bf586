//! Hashes of the files that a run reads.

use std::path::Path;

use crate::batch::Job;
use crate::results::{InputHash, hash_input};
use crate::robot::Robot;

/// Hashes of the files of the robot, of the models of objects, and of those that the scenario names.
pub(in crate::batch) fn input_hashes(job: &Job) -> Vec<InputHash> {
    let robots = std::iter::once(&job.robot).chain(&job.objects);
    robots
        .flat_map(|robot| robot_hashes(robot))
        .chain(job.run.inputs.iter().map(|input| hash_input(&input.name(), &input.bytes)))
        .collect()
}

/// Hashes of the files of a robot, named relative to its folder.
fn robot_hashes(robot: &Robot) -> impl Iterator<Item = InputHash> {
    let home = robot.files.first().and_then(|(path, _)| path.parent()).unwrap_or(Path::new(""));
    let name = move |path: &Path| match path.strip_prefix(home) {
        Ok(below) => below.display().to_string(),
        Err(_) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    };
    robot.files.iter().map(move |(path, bytes)| hash_input(&name(path), bytes))
}
