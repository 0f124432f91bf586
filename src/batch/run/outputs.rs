//! Files and data that a run leaves besides its record.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::batch::{Job, RunEnd};
use crate::results::ReferenceMotion;
use crate::sim::Problems;

/// What a run shall leave besides its record.
#[derive(Clone, Debug, Default)]
pub struct RunOutputs {
    /// Where its log goes; none: no log.
    pub log: Option<PathBuf>,
    /// The folder of its contact problems; none: they are not wanted.
    pub problems: Option<(PathBuf, Problems)>,
    /// What becomes of its motion.
    pub track: Track,
}

/// What becomes of a run's motion.
#[derive(Clone, Debug, Default)]
pub enum Track {
    /// Nothing.
    #[default]
    Nothing,
    /// It is kept for others to be compared with, at so many samples per second, Hz.
    Keep(f64),
    /// It is compared with a reference.
    Compare(Arc<ReferenceMotion>),
}

/// What happens in a run: the job, what it shall leave, and the flag that ends it.
pub type Body<'a> = dyn Fn(&Job, &RunOutputs, &AtomicBool) -> RunEnd + Sync + 'a;
