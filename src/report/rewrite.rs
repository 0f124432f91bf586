//! Writes summary and page of a folder again, from the records in it.

use std::path::Path;

use crate::files::{RecordError, remove_partial};
use crate::history::History;
use crate::report::{Pictured, ShownBatch, ShownHistory, found_runs, write_report_of};
use crate::results::claims::read_claims;
use crate::results::searches::read_searches;
use crate::results::{FoundRun, Listing, SampledRuns, SummaryFiles, SummaryRow, write_summary_of};

/// Writes summary and `page` of `folder` from the records listed in it. Runs at the positions `selected`
/// are part of the bounded sample that the page shows, with a history of results if there is one. Returns the files of the summary and the rows of
/// the sample.
///
/// # Errors
/// A file cannot be written.
pub fn rewrite_results(
    folder: &Path,
    listing: &Listing,
    selected: &[usize],
    (page, pictured, history): (&Path, &Pictured, Option<&History>),
) -> Result<(SummaryFiles, Vec<SummaryRow>), RecordError> {
    let rows = listing.rows(selected);
    remove_partial(folder);
    let files = write_summary_of(folder, &rows)?;
    let SampledRuns { statistics, runs } = rows.into_sampled();
    let (rows, reference_rows) = (summary_rows(&runs), summary_rows(&listing.references));
    let (shown, references) = (found_runs(&rows, &runs), found_runs(&reference_rows, &listing.references));
    let ((claims, changes), searches) = (read_claims(folder)?, read_searches(folder)?);
    let history = history.map(|history| ShownHistory { history, changes: &changes });
    let batch = ShownBatch { claims: &claims, searches: &searches, history, pending: &[] };
    write_report_of(page, folder, (&shown, &statistics), &references, (pictured, batch))?;
    Ok((files, rows))
}

fn summary_rows(runs: &[FoundRun]) -> Vec<SummaryRow> {
    runs.iter().map(|run| run.record.summary_row()).collect()
}
