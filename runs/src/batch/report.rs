//! Results of a batch.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::batch::Job;
use crate::files::RecordError;
use crate::results::claims::{ClaimVerdict, Judgement};
use crate::results::searches::{SearchResult, SearchVerdict};
use crate::results::{RunStatistics, SummaryFiles, SummaryRow};
use crate::sim::Outcome;

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its files: `run.json`, and `log.mcap` and the folder `problems` if they exist.
    pub files: Vec<PathBuf>,
    /// When `run.json` was written.
    pub recorded: Option<SystemTime>,
    /// Additional notes.
    pub notes: Vec<String>,
    /// Its row of the summary.
    pub row: SummaryRow,
    /// True if it ended as expected: `passed`, `fallen` with every expectation held, or in the way
    /// that an expectation names.
    pub accepted: bool,
    /// True if one of its files could not be written because the disk or a quota is full.
    pub storage_full: bool,
}

impl Finished {
    /// True if this run of `job` needs more repetitions for timing.
    pub(in crate::batch) fn needs_repetitions(&self, job: &Job) -> bool {
        let whole = matches!(self.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen);
        whole && job.repetitions() > self.row.repeats.map_or(0, |repeats| repeats.count)
    }
}

/// What the page on a batch shows.
#[derive(Clone, Copy, Debug)]
pub struct ShownResults<'a> {
    /// Folder of the results, in which the page will be.
    pub output: &'a Path,
    /// Finished runs, see [`Report::finished`].
    pub finished: &'a [&'a Finished],
    /// Statistics of all finished runs.
    pub statistics: &'a RunStatistics,
    /// Finished reference runs.
    pub references: &'a [&'a Finished],
    /// Results of the claims.
    pub claims: &'a [ClaimVerdict],
    /// Results of the searches.
    pub searches: &'a [SearchResult],
}

/// Makes the text of the page on a batch, as `report::batch_page` of the package `stiction` does.
pub type PageText = fn(&ShownResults) -> Result<String, RecordError>;

/// Outcome of a batch.
#[derive(Clone, Debug)]
pub struct Report {
    /// Statistics of all finished runs.
    pub statistics: RunStatistics,
    /// Finished runs in the order of the plan; if there are more than
    /// [`SAMPLE_SIZE`](crate::results::SAMPLE_SIZE), the first refused and the first other ones.
    pub finished: Vec<Finished>,
    /// Number of finished runs that were not accepted, failed expectations excluded.
    pub unfinished: usize,
    /// Number of finished runs with a failed expectation.
    pub failed: usize,
    /// Finished reference runs, in the order in which they are first needed; they have no row in
    /// the summary.
    pub references: Vec<Finished>,
    /// Runs that were never started, those that are not needed excluded.
    pub not_started: usize,
    /// Runs that were not started, since their claims are decided.
    pub not_needed: usize,
    /// Results of the claims; none of a part of a batch.
    pub claims: Vec<ClaimVerdict>,
    /// `claims.json`; none without claims.
    pub claims_file: Option<PathBuf>,
    /// Results of the searches.
    pub searches: Vec<SearchResult>,
    /// Their files; none without searches.
    pub search_files: Vec<PathBuf>,
    /// True for one of several parts of a batch.
    pub is_part: bool,
    /// True if it was interrupted.
    pub interrupted: bool,
    /// The summary's files; none when no run finished.
    pub summary: Option<SummaryFiles>,
    /// `report.html`; none when no run finished.
    pub page: Option<PathBuf>,
    /// `runs.jsonl`.
    pub runs_log: PathBuf,
}

impl Report {
    /// True if some run did not reach its end, other than as expected.
    pub fn has_unfinished(&self) -> bool {
        let mut refused = self.references.iter().filter(|f| !f.accepted);
        self.unfinished > 0
            || refused.any(|f| !matches!(f.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen))
    }

    /// True if an expectation did not hold.
    pub fn has_failed(&self) -> bool {
        self.failed > 0
    }

    /// True if a claim has this result.
    pub fn has_claim(&self, judgement: Judgement) -> bool {
        self.claims.iter().any(|claim| claim.verdict == judgement)
    }

    /// True if a search has no result, unless the batch is a part, which `merge` judges.
    pub fn has_open_search(&self) -> bool {
        !self.is_part && self.searches.iter().any(|search| search.verdict != SearchVerdict::Found)
    }
}
