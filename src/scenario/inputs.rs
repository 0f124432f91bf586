//! Files that a scenario names beside its robot, such as motions and scripts: read when it is expanded, so that a run's key, its
//! records and what is simulated rest on the same bytes.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::file::resolve;
use super::scenario::Scenario;
use crate::files::input::{self, MOST_DATA};
use crate::scenario::findings::Findings;
use crate::scenario::key_path::KeyPath;
use crate::text::toml_tree::Node;

/// One such file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Input {
    /// Dotted path of the value that names it, such as `task.0.file`.
    pub key: String,
    /// Where it was found.
    pub path: PathBuf,
    /// What it held.
    pub bytes: Arc<[u8]>,
}

impl Input {
    /// Its name without folders.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// The files read so far; a file that many runs name is read once.
#[derive(Default)]
pub(super) struct Files {
    read: HashMap<PathBuf, Result<Arc<[u8]>, String>>,
}

impl Files {
    /// The files of one run of the scenario file `file`; what cannot be read is told where `root` names it.
    pub fn of(&mut self, scenario: &Scenario, file: &Path, root: &Node, findings: &mut Findings) -> Vec<Input> {
        let mut inputs = Vec::new();
        for (key, written) in named(scenario) {
            let path = resolve(file, Path::new(written));
            let read = self.read.entry(path.clone()).or_insert_with_key(|path| match input::read(path, MOST_DATA) {
                Ok(bytes) => Ok(bytes.into()),
                Err(error) => Err(format!("cannot read {}: {error}", path.display())),
            });
            match read {
                Ok(bytes) => inputs.push(Input { key, path, bytes: bytes.clone() }),
                Err(message) => findings.error(KeyPath::internal(&key).locate(root).1, message.clone(), None),
            }
        }
        inputs
    }
}

/// Dotted paths of the values that name files, and these names as written.
fn named(scenario: &Scenario) -> impl Iterator<Item = (String, &str)> {
    let tasks = scenario.task.iter().enumerate();
    let forces = scenario.force.iter().enumerate();
    let of_tasks = tasks.filter_map(|(i, task)| Some((format!("task.{i}.file"), task.file()?)));
    of_tasks.chain(forces.filter_map(|(i, force)| Some((format!("force.{i}.file"), force.file()?))))
}
