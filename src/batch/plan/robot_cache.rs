//! Caches robots: each file is loaded once per inertia policy.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::robot::{self, InertiaPolicy, Robot, RobotError};
use crate::scenario::{InertiaSpec, RobotSpec};

/// The robots of a batch.
#[derive(Default)]
pub(in crate::batch) struct Robots {
    loaded: HashMap<(PathBuf, Option<InertiaPolicy>), Result<Arc<Robot>, RobotError>>,
}

impl Robots {
    /// The robot at a path under the scenario's inertia policy.
    pub fn get(&mut self, path: &Path, spec: &RobotSpec) -> Result<Arc<Robot>, RobotError> {
        // Different paths of one file share a robot; the loader reports a missing file.
        let policy = spec.inertia.map(|inertia| match inertia {
            InertiaSpec::Refuse => InertiaPolicy::Refuse,
            InertiaSpec::Repair => InertiaPolicy::Repair,
        });
        let identity = (path.canonicalize().unwrap_or_else(|_| path.to_owned()), policy);
        self.loaded.entry(identity).or_insert_with(|| robot::load_with(path, policy).map(Arc::new)).clone()
    }
}
