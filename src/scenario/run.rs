//! From one file to its runs: overrides, then every combination of the swept values, each judged as a whole.

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
use crate::scenario::key_path::KeyPath;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::text::source::Sources;
use crate::text::toml_tree::Node;

/// The most runs a file may expand to when nothing else is said.
pub const DEFAULT_MAX_RUNS: usize = 10_000;

/// Diagnostics of one run that are shown at their places.
const MOST_PLACES: usize = 100;

/// One run of a scenario, everything decided.
#[derive(Clone, Debug)]
pub struct Run {
    /// The scenario's name.
    pub name: String,
    /// The scenario's file, as it was named.
    pub file: PathBuf,
    /// Position among the runs of the file, from 0.
    pub index: usize,
    /// Every value, defaults included.
    pub scenario: Scenario,
    /// The swept values, under their dotted names as written, in the order of the file; a key that only other runs sweep
    /// (`list`) has the value it has here, and is left out where that is a table of defaults. Repetitions differ in
    /// `scenario.seed` and are not listed.
    pub parameters: Vec<(String, toml::Value)>,
    /// `scenario` as TOML; it reads back to the same.
    pub resolved_toml: String,
    /// What is probably not meant. A warning that several runs of a file share stands with the first of them.
    pub warnings: Diagnostics,
    /// The run it is compared with.
    pub reference: Option<Box<Run>>,
    /// The files it names beside its robot.
    pub inputs: Vec<Input>,
    /// What changes while it goes on, in the order in which it happens.
    pub events: Vec<Event>,
    /// Where the values come from.
    pub origin: Origin,
}

/// Where the values of a run were written: the file with its overrides, and what the sweep put into it.
#[derive(Clone, Debug)]
pub struct Origin {
    pub(super) sources: Sources,
    pub(super) base: Arc<Node>,
    pub(super) swept: Vec<(KeyPath, Node)>,
    /// Diagnostics made so far.
    pub(super) told: Arc<AtomicUsize>,
}

impl Origin {
    /// The tree of the values.
    pub(super) fn tree(&self) -> Node {
        let mut root = Node::clone(&self.base);
        for (path, value) in &self.swept {
            // These have been set before, when the run was made.
            let _ = path.set(&mut root, value.clone());
        }
        root
    }

    /// Remembers another value that was set.
    pub(super) fn put(&mut self, path: &KeyPath, value: &Node) {
        self.swept.push((path.clone(), value.clone()));
    }
}

impl Run {
    /// The file that the value at a dotted path (such as `task.0.file`) names.
    pub fn input(&self, key: &str) -> Option<&Input> {
        self.inputs.iter().find(|input| input.key == key)
    }

    /// The values as they were written, those of overrides and sweep among them, defaults not.
    pub fn written(&self) -> toml::Table {
        match self.origin.tree().to_toml() {
            toml::Value::Table(table) => table,
            _ => toml::Table::new(),
        }
    }

    /// Where a path written in the scenario leads: relative ones start at the scenario file's folder.
    pub fn resolve(&self, written: impl AsRef<Path>) -> PathBuf {
        resolve(&self.file, written.as_ref())
    }

    /// An error about the value at a dotted path (such as `force.0.link`), shown where that value of this run was written,
    /// be it in the file, its sweep or an override. For what can only be told with the robot at hand.
    pub fn error_at(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        self.diagnose(path, Severity::Error, false, message.into(), help)
    }

    /// The same, shown at the key: for names that are keys, such as `task.0.joints.knee`.
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
        // Each looks through the whole file; nobody reads so many.
        if self.origin.told.fetch_add(1, Ordering::Relaxed) >= MOST_PLACES {
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
    /// See there.
    pub fn expand(&self, overrides: &[(String, toml::Value)]) -> Result<Vec<Run>, Diagnostics> {
        self.expand_at_most(overrides, DEFAULT_MAX_RUNS)
    }

    /// The runs of the file in a fixed order: the dimensions of the sweep (each key of `grid`, each table of `zip`, `list`,
    /// `random`) are nested in the order of the file, the last one changing fastest, and repetitions change faster still.
    ///
    /// `overrides` are values under dotted paths that replace those of the file, as `--set` gives them. A swept key that
    /// is overridden keeps that one value.
    ///
    /// # Errors
    /// Everything found wrong with any of the runs; more than `max_runs` of them.
    pub fn expand_at_most(
        &self,
        overrides: &[(String, toml::Value)],
        max_runs: usize,
    ) -> Result<Vec<Run>, Diagnostics> {
        let mut runs = Vec::new();
        let idle = self.expansion(overrides, max_runs)?.check(&mut |run| runs.push(run))?;
        if let Some(first) = runs.first_mut() {
            first.warnings.0.extend(idle.0);
        }
        Ok(runs)
    }
}
