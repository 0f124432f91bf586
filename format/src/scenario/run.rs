//! A run of a scenario with all its values, and the expansion of a file to its runs.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use super::events::Event;
use super::file::{ScenarioFile, resolve};
use super::inputs::Input;
use super::scenario::Scenario;
use super::world::WorldNodes;
use crate::scenario::key_path::KeyPath;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::text::source::Sources;
use crate::text::toml_tree::Node;

/// Greatest number of runs of a file by default.
pub const DEFAULT_MAX_RUNS: usize = 10_000;

/// Greatest number of diagnostics of one run that have a position; each takes a pass over the file.
const MAX_POSITIONS: usize = 100;

/// One run of a scenario, with every value decided.
#[derive(Clone, Debug)]
pub struct Run {
    /// The scenario's name.
    pub name: String,
    /// The scenario's file, as the user named it.
    pub file: PathBuf,
    /// Position among the runs of the file, from 0.
    pub index: usize,
    /// Every value, defaults included.
    pub scenario: Scenario,
    /// The swept values by their dotted keys, in the order of the file. A key that only other runs
    /// sweep (`list`) has this run's value, and is left out where that is a table of defaults.
    /// Repetitions differ in `scenario.seed` and are not listed.
    pub parameters: Vec<(String, toml::Value)>,
    /// `scenario` as TOML; parsing it gives the same scenario.
    pub resolved_toml: String,
    /// Warnings. A warning that several runs of a file share belongs to the first of them.
    pub warnings: Diagnostics,
    /// The reference run for `[compare]`.
    pub reference: Option<Box<Run>>,
    /// The files it names, except its robot and the models of objects.
    pub inputs: Vec<Input>,
    /// Its events in order of time.
    pub events: Vec<Event>,
    /// Origin of its values.
    pub origin: Origin,
}

/// Origin of the values of a run: the file with its overrides, or the sweep.
#[derive(Clone, Debug)]
pub struct Origin {
    pub(super) sources: Sources,
    pub(super) base: Arc<Node>,
    pub(super) swept: Vec<(KeyPath, Node)>,
    /// Entries of the world file.
    pub(super) world: Option<Arc<WorldNodes>>,
    /// Values set after the world was added: by a reference or events.
    pub(super) added: Vec<(KeyPath, Node)>,
    /// Diagnostics reported so far.
    pub(super) reported: Arc<AtomicUsize>,
}

impl Origin {
    /// The tree of the values.
    pub(super) fn tree(&self) -> Node {
        let mut root = Node::clone(&self.base);
        // Setting these succeeded when the run was created.
        for (path, value) in &self.swept {
            let _ = path.set(&mut root, value.clone());
        }
        if let Some(world) = &self.world {
            world.insert(&mut root);
        }
        for (path, value) in &self.added {
            let _ = path.set(&mut root, value.clone());
        }
        root
    }

    /// Adds a value that was set.
    pub(super) fn add(&mut self, path: &KeyPath, value: &Node) {
        self.added.push((path.clone(), value.clone()));
    }
}

impl Run {
    /// The file that the value at a dotted path (such as `task.0.file`) names.
    pub fn input(&self, key: &str) -> Option<&Input> {
        self.inputs.iter().find(|input| input.key == key)
    }

    /// The objects that are models: index among `[[object]]`, and the path of their robot file or URDF.
    pub fn object_models(&self) -> impl Iterator<Item = (usize, PathBuf)> {
        let objects = self.scenario.object.iter().enumerate();
        objects.filter_map(|(i, object)| Some((i, self.resolve(object.model()?))))
    }

    /// The values as written, with overrides and sweep, without defaults.
    pub fn written_values(&self) -> toml::Table {
        self.origin.tree().to_table()
    }

    /// Resolves a path written in the scenario, relative to the scenario file's folder.
    pub fn resolve(&self, written: impl AsRef<Path>) -> PathBuf {
        resolve(&self.file, written.as_ref())
    }

    /// An error about the value at a dotted path (such as `force.0.link`), shown where this run's
    /// value was written: in the file, its sweep or an override. For errors that depend on the
    /// robot.
    pub fn error_at(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        self.diagnose(path, Severity::Error, false, message.into(), help)
    }

    /// As [`Run::error_at`], shown at the key: for keys that are names, such as
    /// `task.0.joints.knee`.
    pub fn error_at_key(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        self.diagnose(path, Severity::Error, true, message.into(), help)
    }

    pub(super) fn diagnose(
        &self,
        path: &str,
        severity: Severity,
        at_key: bool,
        message: String,
        help: Option<String>,
    ) -> Diagnostic {
        if self.origin.reported.fetch_add(1, Ordering::Relaxed) >= MAX_POSITIONS {
            let file = self.file.display().to_string();
            let mut diagnostic = Diagnostic::whole_file(file, format!("{path}: {message}"));
            (diagnostic.severity, diagnostic.help) = (severity, help);
            return diagnostic;
        }
        let (key, value) = KeyPath::internal(path).locate(&self.origin.tree());
        Diagnostic::new(severity, &self.origin.sources, if at_key { &key } else { &value }, message, help)
    }
}

impl ScenarioFile {
    /// The runs of the file, at most [`DEFAULT_MAX_RUNS`]. See [`ScenarioFile::expand_at_most`].
    ///
    /// # Errors
    /// See [`ScenarioFile::expand_at_most`].
    pub fn expand(&self, overrides: &[(String, toml::Value)]) -> Result<Vec<Run>, Diagnostics> {
        self.expand_at_most(overrides, DEFAULT_MAX_RUNS)
    }

    /// The runs of the file in a fixed order. The dimensions of the sweep (each key of `grid`, each
    /// table of `zip`, `list`, `random`) are nested in the order of the file, the last one changing
    /// fastest, and repetitions change faster still.
    ///
    /// `overrides` are values by dotted path that replace those of the file, as `--set` gives them.
    /// An overridden key is not swept.
    ///
    /// # Errors
    /// The errors of all runs; more than `max_runs` runs.
    pub fn expand_at_most(
        &self,
        overrides: &[(String, toml::Value)],
        max_runs: usize,
    ) -> Result<Vec<Run>, Diagnostics> {
        let mut runs = Vec::new();
        let unused = self.expansion(overrides, max_runs)?.check(&mut |run| runs.push(run))?;
        if let Some(first) = runs.first_mut() {
            first.warnings.0.extend(unused.0);
        }
        Ok(runs)
    }
}
