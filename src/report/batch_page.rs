//! The page on a batch that has just ended.

use super::{Pictured, ReportRun, ShownBatch, report_html};
use crate::batch::{Finished, ShownResults};
use crate::files::{RecordError, names};
use crate::results::{Machine, PROGRAM};

/// The text of `report.html`, which will be in the folder of the results next to the summary.
///
/// # Errors
/// A picture cannot be drawn.
pub fn batch_page(shown: &ShownResults) -> Result<String, RecordError> {
    let ShownResults { output, finished, statistics, references, claims, searches } = *shown;
    let machine = Machine::here();
    let (runs, references) = (as_reported(finished, &machine), as_reported(references, &machine));
    let pending = &[names::SUMMARY_CSV, names::SUMMARY_PARQUET];
    let batch = ShownBatch { claims, searches, history: None, pending };
    report_html(&output.join(names::REPORT), output, (&runs, statistics), &references, (&Pictured::Few, batch))
}

fn as_reported<'a>(finished: &[&'a Finished], machine: &'a Machine) -> Vec<ReportRun<'a>> {
    let run = |f: &&'a Finished| ReportRun {
        row: &f.row,
        origin: Some((PROGRAM, machine)),
        notes: &f.notes,
        files: &f.files,
    };
    finished.iter().map(run).collect()
}
