//! A plan of which only some runs are left.

use super::{Filter, Selection};
use crate::batch::Plan;
use crate::scenario::Diagnostic;

impl Plan {
    /// Keeps the runs that are meant, in their order, and the references that these need.
    ///
    /// # Errors
    /// A comparison was possible with no run; the plan is as it was.
    pub fn select(&mut self, filter: &Filter) -> Result<(), Box<Diagnostic>> {
        let mut selection = Selection::new(filter);
        let taken: Vec<usize> =
            self.jobs().filter(|job| selection.takes(&job.run, &job.key)).map(|job| job.index).collect();
        selection.end()?;
        self.keep(&taken);
        Ok(())
    }
}
