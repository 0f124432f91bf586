//! Caches robots: each file is loaded once per inertia policy.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::robot::{self, InertiaPolicy, Robot, RobotError};
use crate::scenario::{InertiaSpec, Run};

/// The robots of a batch.
#[derive(Default)]
pub(in crate::batch) struct Robots {
    /// By the file's canonical path.
    loaded: HashMap<(PathBuf, Option<InertiaPolicy>), Result<Arc<Robot>, RobotError>>,
    /// Canonical paths; resolving one costs system calls for each of its folders.
    canonical: HashMap<PathBuf, PathBuf>,
}

impl Robots {
    /// The robot of a run and the models of its objects.
    pub fn of_run(&mut self, run: &Run) -> Result<(Arc<Robot>, Vec<Arc<Robot>>), RobotError> {
        let spec = &run.scenario.robot;
        let robot = self.get(&run.resolve(&spec.model), spec.inertia)?;
        let objects: Result<_, _> = run.object_models().map(|(_, path)| self.get(&path, None)).collect();
        Ok((robot, objects?))
    }

    /// The robot at a path under an inertia policy of the scenario.
    pub fn get(&mut self, path: &Path, inertia: Option<InertiaSpec>) -> Result<Arc<Robot>, RobotError> {
        // Different paths of one file share a robot; the loader reports a missing file.
        let policy = inertia.map(|inertia| match inertia {
            InertiaSpec::Refuse => InertiaPolicy::Refuse,
            InertiaSpec::Repair => InertiaPolicy::Repair,
        });
        let canonical = match self.canonical.get(path) {
            Some(known) => known.clone(),
            None => {
                let found = path.canonicalize().unwrap_or_else(|_| path.to_owned());
                self.canonical.insert(path.to_owned(), found.clone());
                found
            }
        };
        self.loaded.entry((canonical, policy)).or_insert_with(|| robot::load_with(path, policy).map(Arc::new)).clone()
    }
}
