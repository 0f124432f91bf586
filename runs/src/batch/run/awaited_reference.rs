//! Reference run that a run is compared with.

use std::sync::Arc;

use crate::results::ReferenceMotion;
use crate::sim::RunError;

/// The reference run that a run is compared with.
#[derive(Clone, Debug)]
pub(in crate::batch) struct AwaitedReference {
    /// Its key.
    pub key: String,
    /// Its trajectory, or why there is none.
    pub result: Result<Arc<ReferenceMotion>, RunError>,
}
