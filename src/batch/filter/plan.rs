//! A plan of which only some runs are left.

use std::collections::HashMap;

use super::{Filter, Selection};
use crate::batch::{Job, Plan, Role};
use crate::scenario::Diagnostic;

impl Plan {
    /// Keeps the runs that are meant, in their order, and the references that these need.
    ///
    /// # Errors
    /// A comparison was possible with no run; the plan is as it was.
    pub fn select(&mut self, filter: &Filter) -> Result<(), Box<Diagnostic>> {
        let mut selection = Selection::new(filter);
        let taken: Vec<bool> = self.jobs.iter().map(|job| selection.takes(&job.run, &job.key)).collect();
        selection.end()?;
        let mut kept = taken.iter();
        self.jobs.retain(|_| kept.next().is_some_and(|taken| *taken));
        let (mut needed, mut places) = (Vec::new(), HashMap::new());
        for (index, job) in self.jobs.iter_mut().enumerate() {
            job.index = index;
            if let Role::Run { reference: Some(reference) } = &mut job.role {
                *reference = *places.entry(*reference).or_insert_with_key(|old| {
                    needed.push(*old);
                    needed.len() - 1
                });
            }
        }
        let left = |(index, old): (usize, usize)| Job { index, ..self.references[old].clone() };
        let references = needed.into_iter().enumerate().map(left);
        self.references = references.collect();
        Ok(())
    }
}
