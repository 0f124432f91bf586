//! Results of a batch.

use std::path::PathBuf;

use crate::results::{RunStatistics, SummaryFiles, SummaryRow};
use crate::sim::Outcome;

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its files: `run.json`, and `log.mcap` and the folder `problems` if they exist.
    pub files: Vec<PathBuf>,
    /// Additional notes.
    pub notes: Vec<String>,
    /// Its row of the summary.
    pub row: SummaryRow,
    /// It ended as it should: `passed`, `fallen` with every expectation held, or in the way that an expectation names.
    pub accepted: bool,
}

/// Outcome of a batch.
#[derive(Clone, Debug)]
pub struct Report {
    /// Statistics of all finished runs.
    pub statistics: RunStatistics,
    /// Finished runs in the order of the plan; if there are more than
    /// [`SAMPLE_SIZE`](crate::results::SAMPLE_SIZE), the first refused and the first other ones.
    pub finished: Vec<Finished>,
    /// Number of finished runs that did not end as they should, failed expectations excluded.
    pub unfinished: usize,
    /// Number of finished runs with a failed expectation.
    pub failed: usize,
    /// Finished reference runs, in the order in which they are first needed; they have no row in the summary.
    pub references: Vec<Finished>,
    /// Runs that were never started.
    pub not_started: usize,
    /// Was it interrupted?
    pub interrupted: bool,
    /// The summary's files; none when no run finished.
    pub summary: Option<SummaryFiles>,
    /// `report.html`; none when no run finished.
    pub page: Option<PathBuf>,
    /// `runs.jsonl`.
    pub runs_log: PathBuf,
}

impl Report {
    /// Did some run not reach its end, other than as expected?
    pub fn has_unfinished(&self) -> bool {
        let mut refused = self.references.iter().filter(|f| !f.accepted);
        self.unfinished > 0
            || refused.any(|f| !matches!(f.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen))
    }

    /// Did an expectation not hold?
    pub fn has_failed(&self) -> bool {
        self.failed > 0
    }

    /// Summary rows of the runs in `finished`.
    pub fn rows(&self) -> Vec<SummaryRow> {
        self.finished.iter().map(|f| f.row.clone()).collect()
    }
}
