//! Names of columns, and digests of the cells that identify a run.

use std::collections::HashMap;

use crate::metrics::NUMERIC_COLUMNS;

/// Digest that identifies a run.
pub(crate) type RunDigest = [u8; 16];

/// Names of columns with their positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    names: Vec<String>,
    positions: HashMap<String, usize>,
}

impl Columns {
    /// Columns with these names.
    pub fn new(names: impl IntoIterator<Item = String>) -> Self {
        let mut columns = Columns::default();
        names.into_iter().for_each(|name| {
            columns.add(name);
        });
        columns
    }

    /// Adds a column.
    pub fn add(&mut self, name: String) {
        self.positions.entry(name.clone()).or_insert(self.names.len());
        self.names.push(name);
    }

    /// Position of a column.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions.get(name).copied()
    }

    /// Names in their order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.names.len()
    }
}

/// True if the column has measured numbers, not swept parameters or text. Tables of other programs have
/// `error_...` columns of their own.
pub(crate) fn is_measured(column: &str) -> bool {
    NUMERIC_COLUMNS.contains(&column) || column.starts_with("error_")
}

/// Digest of texts that identify a run. Sixteen bytes: among a million runs, two equal digests of
/// different texts have a probability below 1e-26.
pub(crate) fn digest<'a>(texts: impl IntoIterator<Item = &'a str>) -> RunDigest {
    let mut hasher = blake3::Hasher::new();
    for text in texts {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    }
    let mut digest = RunDigest::default();
    hasher.finalize_xof().fill(&mut digest);
    digest
}
