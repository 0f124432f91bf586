//! Scenarios with files beside them.

use super::runs::{Recording, finish};
use std::fs;
use std::path::Path;
use stiction::assemble;
use stiction::robot;
use stiction::scenario::{self, Diagnostics, Run};
use stiction::sim::{Metrics, Simulation};

/// A temporary folder with the files of a scenario.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// With these files in it.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The only run of a scenario in the folder, given as text; `ROBOTS` stands for the
    /// repository's folder of robots.
    pub fn run(&self, text: &str) -> Result<Run, Diagnostics> {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
        let text = text.replace("ROBOTS", robots.to_str().unwrap());
        Ok(scenario::parse(&self.path().join("s.toml"), text)?.expand(&[])?.remove(0))
    }

    /// The error of a scenario, from any stage of loading.
    pub fn refused(&self, text: &str) -> Diagnostics {
        let run = match self.run(text) {
            Ok(run) => run,
            Err(found) => return found,
        };
        assemble::setup(&run, &robot_of(&run)).err().unwrap_or_else(|| panic!("not refused: {text}"))
    }

    /// Runs a scenario to its end.
    pub fn watch(&self, text: &str) -> (Metrics, Recording, Vec<String>) {
        let run = self.run(text).unwrap_or_else(|e| panic!("{e}"));
        let setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
        let notes = setup.notes.clone();
        let mut recorded = Recording::default();
        let metrics = finish(&mut Simulation::new(setup).unwrap_or_else(|e| panic!("{e}")), &mut recorded);
        (metrics, recorded, notes)
    }
}

/// The robot of a run.
pub fn robot_of(run: &Run) -> robot::Robot {
    robot::load(&run.resolve(&run.scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"))
}
