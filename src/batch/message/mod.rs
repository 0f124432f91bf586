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

/// Something that happened.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Message {
    /// Something is to be said about a scenario or a robot, before anything runs.
    Diagnostic(DiagnosticMessage),
    /// Everything is checked and runs are about to start.
    BatchStarted(BatchStarted),
    /// A run began.
    RunStarted(RunMessage),
    /// A run has been going for longer than `--slow` and is not at its end; told once.
    RunSlow(RunSlow),
    /// A run ended and its files are written.
    RunFinished(Box<RunFinished>),
    /// The last line of `runner run`, unless the command line itself was wrong.
    BatchFinished(BatchFinished),
    /// The last line of `runner check`.
    CheckFinished(CheckFinished),
}

/// Something to say about a scenario or a robot.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct DiagnosticMessage {
    /// `error`, `warning` or `note`.
    #[schemars(extend("enum" = ["error", "warning", "note"]))]
    pub severity: &'static str,
    /// What is wrong, in a line.
    pub message: String,
    /// The file, as it was named; `--set` or `--filter` for what was typed there.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// Dotted path of the key it is about, or the element of a robot file.
    pub key: Option<String>,
    /// What to do about it.
    pub help: Option<String>,
    /// All of this as people see it, over several lines.
    pub rendered: String,
}

/// Runs are about to start.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BatchStarted {
    /// This program and its version.
    pub program: &'static str,
    /// Scenario files.
    pub files: Vec<String>,
    /// How many runs.
    pub runs: usize,
    /// How many reference runs, which others are compared with.
    pub references: usize,
    /// How many at a time.
    pub jobs: usize,
    /// Folder of the results.
    pub output: String,
}

/// Which run.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunMessage {
    /// Name of the scenario.
    pub scenario: String,
    /// File of the scenario.
    pub file: String,
    /// Key of the run.
    pub key: String,
    /// What distinguishes it from the other runs of its file, for people; may be empty.
    pub label: String,
    /// Is it a reference run?
    pub reference: bool,
    /// Seed.
    pub seed: u64,
    /// Swept parameters under their dotted names.
    pub parameters: BTreeMap<String, ParamValue>,
}

/// A run that takes its time.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunSlow {
    #[serde(flatten)]
    pub run: RunMessage,
    /// Longer than this, wall clock, s.
    pub after_s: f64,
}

/// What a run came to.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RunFinished {
    #[serde(flatten)]
    pub run: RunMessage,
    /// How it ended.
    #[schemars(schema_with = "outcomes")]
    pub outcome: &'static str,
    /// Did it end as it should: in the way that is expected, every expectation held?
    pub accepted: bool,
    /// Why, when there is something to say.
    pub message: String,
    /// Was it made by an earlier batch that `--resume` goes on with? Then no `run-started` came before.
    pub resumed: bool,
    /// Did it take longer than `--slow`?
    pub slow: bool,
    /// Expectations in the order of the file; none where the run did not get so far as to be judged.
    pub expectations: Vec<Verdict>,
    /// The numeric columns of the summary under their names; null is an empty cell.
    pub metrics: BTreeMap<String, Measure>,
    /// Folder of its records.
    pub folder: String,
    /// The files it left.
    pub files: Vec<String>,
    /// What else there is to tell a person.
    pub notes: Vec<String>,
}

/// What a batch came to.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct BatchFinished {
    /// Exit code of the program.
    pub exit_code: u8,
    /// What went wrong with the batch as a whole.
    pub error: Option<String>,
    /// How many runs have ended in each way.
    pub outcomes: BTreeMap<&'static str, usize>,
    /// Runs that were never started.
    pub not_started: usize,
    /// Was it interrupted?
    pub interrupted: bool,
    /// Files about the batch as a whole.
    pub files: Vec<String>,
}

/// What a check came to.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct CheckFinished {
    /// Exit code of the program.
    pub exit_code: u8,
    /// Scenario files.
    pub files: Vec<String>,
    /// How many runs they expand to.
    pub runs: usize,
    /// How many reference runs these need.
    pub references: usize,
}

fn outcomes(_: &mut schemars::SchemaGenerator) -> Schema {
    json_schema!({ "type": "string", "enum": Outcome::ALL.map(Outcome::name) })
}

impl Message {
    /// The message as a line, with its line break.
    pub fn line(self) -> String {
        // Map keys are texts, and numbers that JSON lacks are written as texts.
        let line = serde_json::to_string(&Line { schema: MESSAGE_SCHEMA, message: self });
        line.map_or_else(|error| format!("{{\"error\":\"{error}\"}}\n"), |line| line + "\n")
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
