//! Writes jobs and their outcomes as messages.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::{BatchFinished, BatchStarted, Message, RunFinished, RunMessage, RunSlow};
use crate::batch::{Finished, Job, Listener, Options, Plan, Report, Role, is_slow};
use crate::results::claims::ClaimVerdict;
use crate::results::searches::SearchResult;
use crate::results::{NUMERIC_COLUMNS, PROGRAM, measure, truth_columns};

/// Converts events to message lines and passes them to a callback.
pub struct MessageWriter<F: FnMut(String)> {
    options: Options,
    write: F,
}

impl<F: FnMut(String)> MessageWriter<F> {
    /// `options` are those of the batch.
    pub fn new(options: &Options, write: F) -> Self {
        MessageWriter { options: options.clone(), write }
    }

    fn emit(&mut self, message: Message) {
        (self.write)(message.line());
    }
}

impl<F: FnMut(String)> Listener for MessageWriter<F> {
    fn started(&mut self, job: &Job) {
        self.emit(Message::RunStarted(job.into()));
    }

    fn slow(&mut self, job: &Job, after: Duration) {
        self.emit(Message::RunSlow(RunSlow { run: job.into(), after_s: after.as_secs_f64() }));
    }

    fn resumed(&mut self, job: &Job, finished: &Finished) {
        self.emit_finished(job, finished, true);
    }

    fn finished(&mut self, job: &Job, finished: &Finished) {
        self.emit_finished(job, finished, false);
    }

    fn searched(&mut self, search: &SearchResult) {
        // The runs are in `searches.json`, and have messages of their own.
        self.emit(Message::SearchEnded(Box::new(SearchResult { probes: Vec::new(), ..search.clone() })));
    }

    fn judged(&mut self, verdict: &ClaimVerdict) {
        // The history is in `claims.json`.
        self.emit(Message::ClaimJudged(Box::new(ClaimVerdict { trace: Vec::new(), ..verdict.clone() })));
    }
}

impl<F: FnMut(String)> MessageWriter<F> {
    fn emit_finished(&mut self, job: &Job, finished: &Finished, resumed: bool) {
        let row = &finished.row;
        let truths = truth_columns(std::slice::from_ref(row));
        let columns = NUMERIC_COLUMNS.into_iter().chain(truths.iter().map(String::as_str));
        let message = RunFinished {
            run: job.into(),
            outcome: row.outcome.name(),
            accepted: finished.accepted,
            message: row.message.clone(),
            resumed,
            slow: is_slow(self.options.slow, row.wall_s),
            expectations: row.verdicts.clone(),
            metrics: columns.map(|name| (name.to_owned(), measure(row, name))).collect(),
            folder: job.folder(&self.options.output).display().to_string(),
            files: finished.files.iter().map(|file| file.display().to_string()).collect(),
            notes: finished.notes.clone(),
        };
        self.emit(Message::RunFinished(Box::new(message)));
    }
}

impl From<&Job> for RunMessage {
    fn from(job: &Job) -> Self {
        RunMessage {
            scenario: job.run.name.clone(),
            file: job.run.file.display().to_string(),
            key: job.key.clone(),
            label: job.label.clone(),
            reference: job.role == Role::Reference,
            seed: job.run.scenario.seed,
            parameters: job.parameters().into_iter().collect(),
        }
    }
}

impl BatchStarted {
    /// Describes a plan before it runs.
    pub fn new(plan: &Plan, options: &Options) -> Self {
        BatchStarted {
            program: PROGRAM,
            files: plan.files.iter().map(|file| file.display().to_string()).collect(),
            runs: plan.runs(),
            references: plan.references(),
            jobs: options.jobs,
            output: options.output.display().to_string(),
        }
    }
}

impl BatchFinished {
    /// Summarises a finished batch; `junit` is the path of the written test results.
    pub fn new(report: &Report, junit: Option<&Path>) -> Self {
        let mut finished = BatchFinished {
            not_started: report.not_started,
            not_needed: report.not_needed,
            interrupted: report.interrupted,
            ..BatchFinished::default()
        };
        finished.outcomes.extend(report.statistics.outcomes());
        for search in &report.searches {
            *finished.searches.entry(search.verdict.name()).or_default() += 1;
        }
        for claim in &report.claims {
            *finished.claims.entry(claim.verdict.name()).or_default() += 1;
        }
        let summary = report.summary.iter().flat_map(|files| [&files.csv, &files.parquet]);
        let own = summary
            .chain(&report.page)
            .chain(&report.search_files)
            .chain(&report.claims_file)
            .chain([&report.runs_log]);
        let own = own.map(PathBuf::as_path);
        finished.files = own.chain(junit).map(|path| path.display().to_string()).collect();
        finished
    }
}
