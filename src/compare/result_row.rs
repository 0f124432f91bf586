//! One row of results.

use std::sync::Arc;

use crate::compare::columns::{Columns, is_measured};
use crate::results::is_truth;

/// Columns of text and the seed, which identify a run and its outcome.
const IDENTITY: [&str; 7] = ["scenario", "key", "outcome", "message", "method", "integrator", "seed"];

/// One run: cells as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultRow {
    columns: Arc<Columns>,
    cells: Vec<String>,
}

impl ResultRow {
    /// A row without cells.
    pub(super) fn blank(columns: Arc<Columns>) -> Self {
        let cells = vec![String::new(); columns.len()];
        Self { columns, cells }
    }

    /// Its cells, emptied.
    pub(super) fn cleared(&mut self) -> &mut [String] {
        self.cells.iter_mut().for_each(String::clear);
        &mut self.cells
    }

    /// A cell; empty when there is none.
    pub fn text(&self, column: &str) -> &str {
        self.columns.position(column).map_or("", |position| &self.cells[position])
    }

    /// The cell at the position of a column.
    pub(crate) fn cell(&self, position: usize) -> &str {
        &self.cells[position]
    }

    /// The swept parameters with their values in the order of their names, without truths.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = (&str, &str)> {
        let cells = self.columns.names().iter().map(String::as_str).zip(self.cells.iter().map(String::as_str));
        let mut found: Vec<_> = cells
            .filter(|(name, value)| {
                let other = IDENTITY.contains(name) || is_measured(name) || is_truth(name) || *name == "verdicts";
                !value.is_empty() && !other
            })
            .collect();
        found.sort_unstable();
        found.into_iter()
    }

    /// A label of the run: scenario, parameters, and a seed other than 1.
    pub(crate) fn label(&self) -> String {
        let mut parts = vec![self.text("scenario").to_owned()];
        parts.extend(self.parameters().map(|(name, value)| format!("{name}={value}")));
        let seed = self.text("seed");
        if seed != "1" && !seed.is_empty() {
            parts.push(format!("seed={seed}"));
        }
        parts.join(" ")
    }
}
