//! Checks the runs of a file in groups, which several threads may do, and collects what they found in
//! the order of the runs.

use super::expansion::{Expansion, MAX_ERRORS};
use super::run::Run;
use super::unused_parameters::UnusedParameters;
use crate::scenario::findings::Findings;
use crate::text::diagnostic::Diagnostics;

/// Findings about some runs of a file.
#[derive(Default)]
pub struct CheckedCells {
    /// All of them, to drop what earlier runs have already.
    known: Findings,
    found: Vec<Findings>,
    unused: UnusedParameters,
}

/// A combination of values, checked.
pub struct CheckedCell {
    /// One of its runs, without its text and swept parameters.
    pub run: Run,
    /// True if its reference has the same seed in each repetition.
    pub reference_has_own_seed: bool,
}

impl CheckedCells {
    /// Checks the values of a run and of its repetitions; `None` if they have an error.
    pub fn check(&mut self, expansion: &Expansion, number: usize) -> Option<CheckedCell> {
        let mut findings = Findings::default();
        let found = expansion.check_cell(number, &mut findings);
        let new = self.known.append(findings);
        if !new.is_empty() {
            self.found.push(new);
        }
        let (run, reference_has_own_seed) = found?;
        self.unused.check(&run);
        Some(CheckedCell { run, reference_has_own_seed })
    }

    /// True if there are so many errors that no further runs are checked.
    pub fn is_full(&self) -> bool {
        self.known.errors() >= MAX_ERRORS
    }
}

/// Findings about all checked runs of a file.
pub struct ExpansionCheck<'a> {
    expansion: &'a Expansion,
    findings: Findings,
    warnings: Diagnostics,
    unused: UnusedParameters,
}

impl<'a> ExpansionCheck<'a> {
    /// Begins without findings.
    pub fn new(expansion: &'a Expansion) -> Self {
        let (findings, warnings, unused) = Default::default();
        ExpansionCheck { expansion, findings, warnings, unused }
    }

    /// Adds the findings about the runs that follow.
    pub fn add(&mut self, cells: CheckedCells) {
        for found in cells.found {
            let new = self.findings.append(found).into_diagnostics(&self.expansion.sources());
            self.warnings.0.extend(new.0);
        }
        self.unused.append(cells.unused);
    }

    /// True if there are so many errors that no further runs are checked.
    pub fn is_full(&self) -> bool {
        self.findings.errors() >= MAX_ERRORS
    }

    /// The warnings about runs, and those about the file as a whole.
    ///
    /// # Errors
    /// All findings, if one of them is an error.
    pub fn finish(self) -> Result<(Diagnostics, Diagnostics), Diagnostics> {
        match self.findings.has_errors() {
            true => Err(self.findings.into_diagnostics(&self.expansion.sources())),
            false => Ok((self.warnings, self.unused.warnings())),
        }
    }
}
