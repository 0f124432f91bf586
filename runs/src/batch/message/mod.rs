//! Messages about a batch for other programs: one JSON object per line.
//!
//! Every line contains [`MESSAGE_SCHEMA`], which changes when a field or message is removed,
//! renamed or given another meaning. Fields and messages may be added; readers must ignore unknown
//! ones.

mod diagnostic;
pub(in crate::batch) mod junit;
mod writer;

pub use writer::MessageWriter;

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, json_schema};
use serde::Serialize;

use crate::files::json;
use crate::results::claims::ClaimVerdict;
use crate::results::searches::SearchResult;
use crate::results::{Measure, ParamValue, Verdict};
use crate::sim::Outcome;

/// Version of the messages.
pub const MESSAGE_SCHEMA: u32 = 1;

/// One line.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(title = "Message")]
pub struct Line {
    /// Version of the messages.
    #[schemars(extend("const" = MESSAGE_SCHEMA))]
    schema: u32,
    #[serde(flatten)]
    message: Message,
}

/// An event of a batch or check.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Message {
    /// An error, warning or note about a scenario or robot, before anything runs.
    Diagnostic(DiagnosticMessage),
    /// All inputs are checked and runs are about to start.
    BatchStarted(BatchStarted),
    /// A run began.
    RunStarted(RunMessage),
    /// An active run exceeds `--slow`; sent once per run.
    RunSlow(RunSlow),
    /// A run ended and its files are written.
    RunFinished(Box<RunFinished>),
    /// A search is at its end, or ended with the batch; after all runs.
    SearchEnded(Box<SearchResult>),
    /// A claim is judged; after all runs.
    ClaimJudged(Box<ClaimVerdict>),
    /// The last line of `runner run`, unless the command line itself was wrong.
    BatchFinished(BatchFinished),
    /// The last line of `runner check`.
    CheckFinished(CheckFinished),
}

/// An error, warning or note about a scenario or robot.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct DiagnosticMessage {
    /// `error`, `warning` or `note`.
    #[schemars(extend("enum" = ["error", "warning", "note"]))]
    pub severity: &'static str,
    /// What is wrong, in a line.
    pub message: String,
    /// The file, as given; `--set` or `--filter` for the text of these options.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// Dotted path of the key, or the element of a robot file.
    pub key: Option<String>,
    /// How to fix it.
    pub help: Option<String>,
    /// The complete text for a terminal, in several lines.
    pub rendered: String,
}

/// Runs are about to start.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BatchStarted {
    /// This program and its version.
    pub program: &'static str,
    /// Scenario files.
    pub files: Vec<String>,
    /// Number of runs; with a search, the greatest number.
    pub runs: usize,
    /// Number of reference runs, which others are compared with.
    pub references: usize,
    /// Maximum number of simultaneous runs.
    pub jobs: usize,
    /// Folder of the results.
    pub output: String,
}

/// A run.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunMessage {
    /// Name of the scenario.
    pub scenario: String,
    /// File of the scenario.
    pub file: String,
    /// Key of the run.
    pub key: String,
    /// Label that distinguishes it from the other runs of its file; may be empty.
    pub label: String,
    /// True for a reference run.
    pub reference: bool,
    /// Seed.
    pub seed: u64,
    /// Swept parameters under their dotted names.
    pub parameters: BTreeMap<String, ParamValue>,
}

/// An active run that exceeds `--slow`.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunSlow {
    #[serde(flatten)]
    pub run: RunMessage,
    /// The limit, wall-clock s.
    pub after_s: f64,
}

/// A finished run.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunFinished {
    #[serde(flatten)]
    pub run: RunMessage,
    /// Outcome.
    #[schemars(schema_with = "outcomes")]
    pub outcome: &'static str,
    /// True if the run ended as expected and every expectation held.
    pub accepted: bool,
    /// Reason of the outcome; may be empty.
    pub message: String,
    /// True for a result of an earlier batch, kept by `--resume`; no `run-started` precedes it.
    pub resumed: bool,
    /// True if it took longer than `--slow`.
    pub slow: bool,
    /// Expectations in the order of the file; empty if the run ended before they were evaluated.
    pub expectations: Vec<Verdict>,
    /// The numeric columns of the summary under their names; null is an empty cell.
    pub metrics: BTreeMap<String, Measure>,
    /// Folder of its records.
    pub folder: String,
    /// Files that it wrote.
    pub files: Vec<String>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// A finished batch.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct BatchFinished {
    /// Exit code of the program.
    pub exit_code: u8,
    /// Error of the batch as a whole.
    pub error: Option<String>,
    /// Number of runs by outcome.
    pub outcomes: BTreeMap<&'static str, usize>,
    /// Runs that were never started.
    pub not_started: usize,
    /// Runs that were not started, since their claims are decided.
    pub not_needed: usize,
    /// Number of searches by verdict.
    pub searches: BTreeMap<&'static str, usize>,
    /// Number of claims by verdict.
    pub claims: BTreeMap<&'static str, usize>,
    /// True if it was interrupted.
    pub interrupted: bool,
    /// Files about the batch as a whole.
    pub files: Vec<String>,
}

/// A finished check.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct CheckFinished {
    /// Exit code of the program.
    pub exit_code: u8,
    /// Scenario files.
    pub files: Vec<String>,
    /// Number of runs they expand to; with a search, the greatest number.
    pub runs: usize,
    /// Number of reference runs these need.
    pub references: usize,
}

fn outcomes(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({ "type": "string", "enum": Outcome::ALL.map(Outcome::name) })
}

impl Message {
    /// The message as a line, with its line break.
    pub fn line(self) -> String {
        // Never an error: map keys are texts, and numbers that JSON lacks are written as texts.
        let line = json::compact(&Line { schema: MESSAGE_SCHEMA, message: self });
        let text = line.map(|line| String::from_utf8_lossy(&line).into_owned());
        text.unwrap_or_else(|error| format!("{{\"error\":\"{error}\"}}")) + "\n"
    }
}

/// JSON Schema of a line.
pub fn message_schema() -> serde_json::Value {
    schemars::generate::SchemaSettings::draft2020_12()
        .for_serialize()
        .into_generator()
        .into_root_schema_for::<Line>()
        .to_value()
}
