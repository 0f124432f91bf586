//! Applies a filter to a plan.

use super::{Filter, Selection};
use crate::batch::Plan;
use crate::scenario::Diagnostic;

impl Plan {
    /// Keeps the selected runs, in order, and the references they need.
    ///
    /// # Errors
    /// A comparison applies to no run; the plan is unchanged.
    pub fn select(&mut self, filter: &Filter) -> Result<(), Box<Diagnostic>> {
        let mut selection = Selection::new(filter);
        let selected: Vec<usize> =
            self.jobs().filter(|job| selection.takes(&job.run, &job.key)).map(|job| job.index).collect();
        selection.end()?;
        self.keep(&selected);
        self.restrict_claims();
        self.filter = Some(filter.to_string());
        Ok(())
    }
}
