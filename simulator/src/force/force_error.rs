//! The error of a force model. It ends the run with outcome `error`.

use std::error::Error;

/// Why a force model cannot give its forces.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ForceError(Box<dyn Error + Send + Sync>);

impl ForceError {
    /// Wraps the error of a model.
    pub fn new(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        ForceError(error.into())
    }
}
