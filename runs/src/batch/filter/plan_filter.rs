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
        if let Some(wrong) =
            filter.names_any(self.searches().flat_map(|(.., search)| &search.axes).map(|axis| axis.name.as_str()))
        {
            return Err(wrong);
        }
        let mut selected: Vec<usize> = Vec::new();
        for index in 0..self.runs() {
            let is_selected = match self.is_first(index) {
                true => {
                    let job = self.job(index);
                    selection.takes(&job.run, &job.key)
                }
                // All runs of a search are selected, or none.
                false => index.checked_sub(1).is_some_and(|before| selected.last() == Some(&before)),
            };
            selected.extend(is_selected.then_some(index));
        }
        selection.end()?;
        self.keep(&selected);
        self.restrict_claims();
        self.filter = Some(filter.to_string());
        Ok(())
    }
}
