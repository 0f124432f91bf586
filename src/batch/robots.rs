//! Each robot is loaded once, however many runs use it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::robot::{self, Robot, RobotError};

/// The robots of a batch.
#[derive(Default)]
pub(super) struct Robots {
    loaded: HashMap<PathBuf, Result<Arc<Robot>, RobotError>>,
}

impl Robots {
    /// The robot at a path, and whether it was loaded just now.
    pub fn get(&mut self, path: &Path) -> (Result<Arc<Robot>, RobotError>, bool) {
        // Two ways to the same file lead to one robot; a file that is not there is the loader's to complain about.
        let identity = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let new = !self.loaded.contains_key(&identity);
        let entry = self.loaded.entry(identity).or_insert_with(|| robot::load(path).map(Arc::new));
        (entry.clone(), new)
    }
}
