//! What a task remembers of its calls, for checkpoints.

use std::any::Any;
use std::sync::Arc;

/// A copy of what a task remembers.
#[derive(Clone)]
pub struct TaskMemory(Arc<dyn Any + Send + Sync>);

impl TaskMemory {
    /// Keeps `memory`.
    pub fn new(memory: impl Any + Send + Sync) -> Self {
        TaskMemory(Arc::new(memory))
    }

    /// What was kept, if it has this type.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.downcast_ref()
    }
}
