//! Writes the results of all shards into one folder.

use crate::files::{RecordError, confined, if_present, modified, names, remove_partial};
use crate::merge::copy_run::copy_run;
use crate::merge::merge_error::MergeError;
use crate::merge::missing::Missing;
use crate::merge::shards::Shards;
use crate::results::FoundRun;
use crate::results::claims::{ClaimVerdict, Tally, write_claims};
use crate::results::searches::{SearchResult, write_searches};
use crate::results::{
    BoundedSample, Rows, RunRecord, RunStatistics, RunsLog, SummaryFiles, SummaryRow, write_summary_of,
};
use crate::sim::Outcome;
use std::path::{Path, PathBuf};

/// The merged results.
#[derive(Debug)]
pub struct Merged {
    /// Statistics of all runs.
    pub statistics: RunStatistics,
    /// A bounded sample of the runs, in the order of the plan.
    pub runs: Vec<FoundRun>,
    /// Reference runs, in the order in which the runs first need them.
    pub references: Vec<FoundRun>,
    /// The summary's files.
    pub summary: SummaryFiles,
    /// `runs.jsonl`.
    pub runs_log: PathBuf,
    /// Results of the searches.
    pub searches: Vec<SearchResult>,
    /// Their files; none without searches.
    pub search_files: Vec<PathBuf>,
    /// Results of the claims.
    pub claims: Vec<ClaimVerdict>,
    /// `claims.json`; none without claims.
    pub claims_file: Option<PathBuf>,
    /// Number of runs and reference runs that did not finish as expected.
    pub unfinished: usize,
    /// Number of runs with a failed expectation.
    pub failed: usize,
    /// Keeps other programs out of the folder.
    pub lock: RunsLog,
}

impl Shards {
    /// Writes the results of all shards into a folder, except the report. Omits the runs that
    /// [`Shards::check`] found missing.
    ///
    /// # Errors
    /// A file cannot be read or written; another program writes there; a reference differs between
    /// two shards.
    pub fn write(&self, output: &Path, missing: &Missing) -> Result<Merged, MergeError> {
        let mut references = Vec::new();
        let runs_log = output.join(names::RUNS_LOG);
        let log = RunsLog::create(&runs_log)?;
        remove_partial(output);
        for name in names::BATCH_OUTPUTS {
            let path = output.join(name);
            if_present(std::fs::remove_file(&path)).map_err(RecordError::io(&path))?;
        }
        for needed in missing.references.whole() {
            let folder = needed.folder();
            confined::check(output, &output.join(&folder))?;
            copy_run(&self.folders[needed.shard].join(&folder), &output.join(&folder))?;
            references.push(read(output.join(folder).join(names::RUN_RECORD))?);
        }
        let (mut statistics, mut sample) = (RunStatistics::default(), BoundedSample::default());
        let (mut unfinished, mut failed) = (0, 0);
        let mut tally = Tally::new(self.heads.first().map(|head| head.claims.clone()).unwrap_or_default());
        self.for_each_run(&mut |holders| {
            let to = holders[0].run.folder(output);
            confined::check(output, &to)?;
            for other in holders[0].run.other_folders(output).filter(|other| other.exists()) {
                confined::check(output, &other)?;
                std::fs::remove_dir_all(&other).map_err(RecordError::io(&other))?;
            }
            let Some(holder) =
                holders.iter().find(|h| h.record().is_file() && !missing.broken.contains(&(h.shard, h.run.at)))
            else {
                if !missing.without_result.contains(&holders[0].run.at) {
                    let what = format!("the result of {} {} is gone", holders[0].run.scenario, holders[0].run.key);
                    return Err(MergeError::Changed { path: holders[0].folder.to_owned(), what });
                }
                // A result of an earlier merge does not belong to these shards.
                let _ = std::fs::remove_dir_all(&to);
                return Ok(());
            };
            copy_run(&holder.run.folder(holder.folder), &to)?;
            let run = read(to.join(names::RUN_RECORD))?;
            let (row, record) = (run.record.summary_row(), &run.record);
            log.push(&row)?;
            for part in &holder.run.claims {
                tally.add(*part, &row);
            }
            let origin = Some((record.program.as_str(), &record.timing.machine));
            statistics.add(&row, origin, run.files.first().and_then(|record| modified(record)));
            failed += usize::from(row.outcome == Outcome::Failed);
            unfinished += usize::from(row.is_refused() && row.outcome != Outcome::Failed);
            sample.insert(holder.run.at, run, row.is_refused());
            Ok(())
        })?;
        let summary = write_summary_of(output, &MergedRows { shards: self, output })?;
        unfinished += references.iter().filter(|r| r.record.summary_row().is_refused()).count();
        let claims = tally.verdicts();
        let claims_file = write_claims(output, &claims, tally.changes())?;
        let searches = self.searches();
        let search_files = write_searches(output, &searches)?;
        let runs = sample.into_sorted();
        Ok(Merged {
            statistics,
            runs,
            references,
            summary,
            runs_log,
            searches,
            search_files,
            claims,
            claims_file,
            unfinished,
            failed,
            lock: log,
        })
    }
}

fn read(record: PathBuf) -> Result<FoundRun, RecordError> {
    let run = RunRecord::read(&record)?;
    Ok(FoundRun::without_inputs(record, run))
}

/// Rows of the merged records, in the order of the plan.
struct MergedRows<'a> {
    shards: &'a Shards,
    output: &'a Path,
}

impl Rows for MergedRows<'_> {
    fn for_each(&self, visit: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        let result = self.shards.for_each_run(&mut |holders| {
            let path = holders[0].run.folder(self.output).join(names::RUN_RECORD);
            // No shard has a result of this run.
            if !path.is_file() {
                return Ok(());
            }
            Ok(visit(&RunRecord::read(&path)?.summary_row())?)
        });
        result.map_err(|error| match error {
            MergeError::Record(error) => error,
            other => RecordError::Io { path: self.output.to_owned(), source: std::io::Error::other(other) },
        })
    }
}
