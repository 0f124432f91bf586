//! Names of the files and folders in a folder of results.

/// The summary as text.
pub const SUMMARY_CSV: &str = "summary.csv";
/// The summary as Parquet.
pub const SUMMARY_PARQUET: &str = "summary.parquet";
/// The report on a batch.
pub const REPORT: &str = "report.html";
/// One line for each run, appended as it ends.
pub const RUNS_LOG: &str = "runs.jsonl";
/// The runs of a shard.
pub const SHARD_LIST: &str = "shard.jsonl";
/// The results of claims.
pub const CLAIMS: &str = "claims.json";
/// The results of searches, with their runs.
pub const SEARCHES: &str = "searches.json";
/// The results of searches, a row for each.
pub const SEARCHES_CSV: &str = "searches.csv";
/// The points of boundaries over two keys.
pub const BOUNDARY_LINES: &str = "boundary-lines.csv";
/// Earlier results, appended by `runner compare`.
pub const HISTORY: &str = "history.parquet";
/// The record of one run.
pub const RUN_RECORD: &str = "run.json";
/// The log of one run.
pub const LOG: &str = "log.mcap";
/// The folder of a run's contact problems.
pub const PROBLEMS: &str = "problems";
/// The folder of a scenario's reference runs.
pub const REFERENCES: &str = "references";
/// The jobs of a submitted sweep.
pub const JOBS: &str = "jobs.json";

/// Files written at the end of a batch, and the shard list; the next batch removes them when it
/// begins.
pub const BATCH_OUTPUTS: [&str; 8] =
    [SUMMARY_CSV, SUMMARY_PARQUET, REPORT, SHARD_LIST, CLAIMS, SEARCHES, SEARCHES_CSV, BOUNDARY_LINES];

/// All files of a batch in its folder of results.
pub const BATCH_FILES: [&str; 9] =
    [SUMMARY_CSV, SUMMARY_PARQUET, RUNS_LOG, REPORT, SHARD_LIST, CLAIMS, SEARCHES, SEARCHES_CSV, BOUNDARY_LINES];

/// Files with the rows of runs, in the order of preference for reading.
pub const SUMMARIES: [&str; 3] = [SUMMARY_CSV, SUMMARY_PARQUET, RUNS_LOG];

/// Files that mark a folder as the results of a batch.
pub const BATCH_MARKERS: [&str; 3] = [SHARD_LIST, RUNS_LOG, SUMMARY_CSV];

/// Files that a table must not replace.
pub const PROTECTED: [&str; 12] = [
    RUN_RECORD,
    JOBS,
    SHARD_LIST,
    RUNS_LOG,
    SUMMARY_CSV,
    SUMMARY_PARQUET,
    REPORT,
    CLAIMS,
    SEARCHES,
    SEARCHES_CSV,
    BOUNDARY_LINES,
    HISTORY,
];

/// Files of one run that may be symbolic links.
pub const LINKABLE: [&str; 2] = [RUN_RECORD, LOG];
