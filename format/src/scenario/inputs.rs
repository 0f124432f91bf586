//! Files that a scenario names, such as motions and scripts.
//!
//! They are read when the scenario is expanded, so that a run's key, its records and its simulation
//! use the same bytes.

use std::{
    collections::HashMap,
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::file::resolve;
use super::scenario::Scenario;
use crate::input::{self, MOST_DATA};
use crate::scenario::findings::Findings;
use crate::scenario::key_path::KeyPath;
use crate::text::toml_tree::Node;

/// A file that a scenario names.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Input {
    /// Dotted path of the value that names it, such as `task.0.file`.
    pub key: String,
    /// Path of the file.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: Arc<[u8]>,
}

impl Input {
    /// Its name without folders.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// The files read so far, each read once.
#[derive(Default)]
pub(super) struct Files {
    read: HashMap<PathBuf, Result<Arc<[u8]>, io::Error>>,
}

impl Files {
    /// Reads the files of one run of the scenario file `file`. A file that cannot be read is an
    /// error at the value of `root` that names it.
    pub fn read(&mut self, scenario: &Scenario, file: &Path, root: &Node, findings: &mut Findings) -> Vec<Input> {
        let mut inputs = Vec::new();
        for (key, written) in named_files(scenario) {
            let path = resolve(file, Path::new(written));
            let bytes = self.read.entry(path.clone());
            match bytes.or_insert_with_key(|path| input::read(path, MOST_DATA).map(Arc::from)) {
                Ok(bytes) => inputs.push(Input { key, path, bytes: bytes.clone() }),
                Err(error) => {
                    let message = format!("cannot read {}: {error}", path.display());
                    findings.error(KeyPath::internal(&key).locate(root).1, message, None);
                }
            }
        }
        inputs
    }
}

/// Dotted paths of the values that name files, and these names as written.
fn named_files(scenario: &Scenario) -> impl Iterator<Item = (String, &str)> {
    let tasks = scenario.task.iter().enumerate();
    let forces = scenario.force.iter().enumerate();
    let of_tasks = tasks.filter_map(|(i, task)| Some((format!("task.{i}.file"), task.file()?)));
    let of_forces = forces.filter_map(|(i, force)| Some((format!("force.{i}.file"), force.file()?)));
    let terrain = scenario.terrain.iter().enumerate();
    let of_terrain = terrain.filter_map(|(i, terrain)| Some((format!("terrain.{i}.file"), terrain.file()?)));
    let objects = scenario.object.iter().enumerate();
    let of_objects = objects.filter_map(|(i, object)| Some((format!("object.{i}.file"), object.file()?)));
    of_tasks.chain(of_forces).chain(of_terrain).chain(of_objects)
}
