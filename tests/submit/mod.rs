//! `runner submit` with a fake Slurm on PATH, which records its calls and, if a test requests it,
//! runs the jobs as Slurm would.

mod fake;
mod folder;
mod jobs;
mod refused;

use std::path::{Path, PathBuf};

use crate::cli::{Done, Place};

pub use fake::Slurm;

/// Scenarios of twelve runs, of which four fail, so the exit code is not 0.
pub fn scenarios() -> Place {
    let place = Place::new();
    place.block(
        "thrown.toml",
        "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.3, 0] }
[[expect]]
metric = \"duration_s\"
max = 0.15
[sweep]
repeat = 2
[sweep.grid]
duration = [0.1, 0.12, 0.2]
\"contact.method\" = [\"exact\", \"one-step\"]
",
    );
    place
}

/// Arguments of a submission, followed by `more`.
pub fn submit<'a>(output: &'a str, parts: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["submit", "--engine", "slurm", "--parts", parts, "--output", output], more].concat()
}

/// A folder with scenarios and a fake Slurm.
pub struct Site {
    pub place: Place,
    pub slurm: Slurm,
}

impl Site {
    pub fn new() -> Self {
        let place = scenarios();
        let slurm = Slurm::new(&place.path("slurm"));
        Site { place, slurm }
    }

    /// Runs the program with this Slurm on PATH.
    pub fn runner(&self, arguments: &[&str]) -> Done {
        let mut command = self.place.command(arguments);
        self.slurm.put_on_path(&mut command);
        Done::from(command.output().unwrap())
    }

    /// A file of the folder `submit`.
    pub fn script(&self, output: &str, name: &str) -> String {
        std::fs::read_to_string(self.place.path(output).join("submit").join(name)).unwrap()
    }

    pub fn jobs(&self, output: &str) -> serde_json::Value {
        serde_json::from_str(&self.script(output, "jobs.json")).unwrap()
    }
}

/// Returns whether a file or folder exists.
pub fn exists(path: impl AsRef<Path>) -> bool {
    path.as_ref().exists()
}

pub fn real(path: PathBuf) -> PathBuf {
    std::path::absolute(path).unwrap()
}
