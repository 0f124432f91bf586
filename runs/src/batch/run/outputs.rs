//! Files and data that a run produces in addition to its record.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::batch::Job;
use crate::batch::run::run_end::RunEnd;
use crate::results::ReferenceMotion;
use crate::sim::Problems;

/// Outputs of a run in addition to its record.
#[derive(Clone, Debug, Default)]
pub struct RunOutputs {
    /// Path of its log; none: no log.
    pub log: Option<PathBuf>,
    /// Folder and selection of its contact problems; none: not written.
    pub problems: Option<(PathBuf, Problems)>,
    /// Use of its motion.
    pub track: Track,
}

/// Use of a run's motion.
#[derive(Clone, Debug, Default)]
pub enum Track {
    /// Discarded.
    #[default]
    Nothing,
    /// Kept for others to be compared with, sampled at this rate, Hz.
    Keep(f64),
    /// Compared with a reference.
    Compare(Arc<ReferenceMotion>),
}

/// Body of a run: takes the job, its outputs and the cancellation flag.
pub type Body<'a> = dyn Fn(&Job, &RunOutputs, &AtomicBool) -> RunEnd + Sync + 'a;
