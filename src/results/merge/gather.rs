//! The results of all shards in one folder.

use crate::files::{RecordError, confined, remove_partial};
use crate::report::{Pictured, ReportRun, write_report_of};
use crate::results::merge::{MergeError, Missing, Shards, place};
use crate::results::rebuild::{FoundRun, files};
use crate::results::{Kept, Rows, RunRecord, RunsLog, SHARD_LIST, SummaryFiles, SummaryRow, Tally, write_summary_of};
use std::path::{Path, PathBuf};

/// What was put together.
#[derive(Debug)]
pub struct Merged {
    /// Numbers of all runs.
    pub tally: Tally,
    /// As many runs as are shown, in the order of the plan.
    pub runs: Vec<FoundRun>,
    /// Their references, in the order in which they are first needed.
    pub references: Vec<FoundRun>,
    /// The summary's files.
    pub summary: SummaryFiles,
    /// `report.html`.
    pub page: PathBuf,
    /// `runs.jsonl`.
    pub runs_log: PathBuf,
    /// Runs that ended as they should not, and did not finish.
    pub unfinished: usize,
    /// Runs of which an expectation did not hold.
    pub failed: usize,
}

impl Shards {
    /// Writes the results of all shards into a folder. Runs that no shard has a whole result of are left out; which these are
    /// [`Shards::check`] has found.
    ///
    /// # Errors
    /// A file cannot be read or written; another program is writing there; a reference that two shards made differs.
    pub fn write(&self, output: &Path, missing: &Missing) -> Result<Merged, MergeError> {
        let mut references = Vec::new();
        let runs_log = output.join("runs.jsonl");
        let mut log = RunsLog::anew(&runs_log)?;
        remove_partial(output);
        for name in ["summary.csv", "summary.parquet", "report.html", SHARD_LIST] {
            match std::fs::remove_file(output.join(name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(RecordError::io(&output.join(name))(error).into());
                }
                _ => {}
            }
        }
        for needed in missing.references.whole() {
            let below = needed.below();
            confined::check(output, &output.join(&below))?;
            place::place(&self.folders[needed.shard].join(&below), &output.join(&below))?;
            references.push(found(output.join(below).join("run.json"))?);
        }
        let (mut tally, mut kept, mut unfinished, mut failed) = (Tally::default(), Kept::default(), 0, 0);
        self.walk(&mut |holders| {
            let to = holders[0].run.folder(output);
            confined::check(output, &to)?;
            let Some(holder) =
                holders.iter().find(|h| h.record().is_file() && !missing.broken.contains(&(h.shard, h.run.at)))
            else {
                // What an earlier one brought there is no result of these shards.
                let _ = std::fs::remove_dir_all(&to);
                return Ok(());
            };
            place::place(&holder.run.folder(holder.folder), &to)?;
            let run = found(to.join("run.json"))?;
            let (row, record) = (run.record.summary_row(), &run.record);
            log.push(&row)?;
            tally.add(&row, &record.program, &record.timing.machine, run.files.first().map(PathBuf::as_path));
            failed += usize::from(row.outcome == crate::sim::Outcome::Failed);
            unfinished += usize::from(row.is_refused() && row.outcome != crate::sim::Outcome::Failed);
            kept.insert(holder.run.at, run, row.is_refused());
            Ok(())
        })?;
        let summary = write_summary_of(output, &OnDisk { shards: self, output })?;
        let (runs, page) = (kept.into_sorted(), output.join("report.html"));
        write_page(&page, output, &runs, &tally, &references)?;
        unfinished += references.iter().filter(|r| r.record.summary_row().is_refused()).count();
        Ok(Merged { tally, runs, references, summary, page, runs_log, unfinished, failed })
    }
}

/// A record without the texts that nobody looks at any more.
fn found(record: PathBuf) -> Result<FoundRun, RecordError> {
    let run = RunRecord::read(&record)?;
    Ok(FoundRun { record: RunRecord { resolved: String::new(), inputs: Vec::new(), ..run }, files: files(record) })
}

fn write_page(
    page: &Path,
    output: &Path,
    runs: &[FoundRun],
    tally: &Tally,
    references: &[FoundRun],
) -> Result<(), RecordError> {
    let rows = |runs: &[FoundRun]| runs.iter().map(|r| r.record.summary_row()).collect::<Vec<SummaryRow>>();
    let (own, others) = (rows(runs), rows(references));
    let reported = as_reported(&own, runs);
    write_report_of(page, output, (&reported, tally), &as_reported(&others, references), &Pictured::Few)
}

fn as_reported<'a>(rows: &'a [SummaryRow], found: &'a [FoundRun]) -> Vec<ReportRun<'a>> {
    rows.iter().zip(found).map(|(row, found)| found.reported(row)).collect()
}

/// The rows of the records that were brought here, in the order of the plan.
struct OnDisk<'a> {
    shards: &'a Shards,
    output: &'a Path,
}

impl Rows for OnDisk<'_> {
    fn each(&self, tell: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        let told = self.shards.walk(&mut |holders| {
            let path = holders[0].run.folder(self.output).join("run.json");
            // What no shard has a result of is not here either.
            if !path.is_file() {
                return Ok(());
            }
            Ok(tell(&RunRecord::read(&path)?.summary_row())?)
        });
        told.map_err(|error| match error {
            MergeError::Record(error) => error,
            other => RecordError::Io { path: self.output.to_owned(), source: std::io::Error::other(other) },
        })
    }
}
