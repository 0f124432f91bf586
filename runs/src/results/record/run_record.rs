//! `run.json`, the record of one run: inputs, outcome, metrics and timing.

use crate::files::{RecordError, json};
use crate::input::{self, MOST_DATA};
use crate::metrics::{Metrics, number};
use crate::results::{Comparison, LogFingerprint, ParamValue, Repeats, SummaryRow, Verdict};
use crate::sim::{AvoidanceTime, Outcome};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::Path;
use std::sync::OnceLock;

/// Format version of `run.json`.
pub const RUN_SCHEMA: u32 = 1;

/// Program and version, as in records.
pub const PROGRAM: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// Build of the program: a hash of its sources.
pub const BUILD: &str = env!("STICTION_BUILD");

/// The record of one finished run. All fields but `timing` depend on the run alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Format version, [`RUN_SCHEMA`].
    pub schema: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// Outcome.
    #[serde(with = "outcome")]
    pub outcome: Outcome,
    /// Reason of the outcome; may be empty.
    pub message: String,
    /// Contact method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// Seed.
    pub seed: u64,
    /// Swept parameters under their dotted names, in file order.
    pub parameters: Vec<(String, ParamValue)>,
    /// Expectations and their results, in file order.
    pub verdicts: Vec<Verdict>,
    /// Metrics.
    pub metrics: Metrics,
    /// Distances from the reference run and from known truths.
    #[serde(default, skip_serializing_if = "Comparison::is_empty")]
    pub comparison: Comparison,
    /// Further notes for the user.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Program and version.
    pub program: String,
    /// Input files.
    pub inputs: Vec<InputHash>,
    /// The resolved scenario, as TOML.
    pub resolved: String,
    /// The log; none without one. Earlier versions did not record it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LogFingerprint>,
    /// Times and machine.
    pub timing: Timing,
}

/// An input file of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputHash {
    /// Name, as the scenario or robot file refers to it.
    pub name: String,
    /// BLAKE3 of its bytes, hexadecimal.
    pub blake3: String,
}

/// Hashes the bytes of an input.
pub fn hash_input(name: &str, bytes: &[u8]) -> InputHash {
    InputHash { name: name.to_owned(), blake3: blake3::hash(bytes).to_hex().to_string() }
}

/// Times of a run and its machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Wall-clock time, s.
    #[serde(with = "number::real")]
    pub wall_s: f64,
    /// Processor time, s.
    #[serde(with = "number::real")]
    pub cpu_s: f64,
    /// Machine.
    pub machine: Machine,
    /// The scenario file as given: relative paths in [`RunRecord::resolved`] begin at its folder.
    /// Earlier versions did not record it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The build of the program, [`BUILD`]. It is not part of the key, since most source changes
    /// change no result. Earlier versions did not record it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build: Option<String>,
    /// Times of repetitions, if there were any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<Repeats>,
    /// Processor time of self-collision avoidance, a part of `cpu_s`; none without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub avoidance: Option<AvoidanceTime>,
}

/// The machine of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Operating system.
    pub os: String,
    /// Processor architecture.
    pub arch: String,
    /// Processors available to the program.
    pub cpus: usize,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        // Reading the limits of the process opens several files, which short runs would notice.
        static CPUS: OnceLock<usize> = OnceLock::new();
        let cpus = *CPUS.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from));
        Self { os: std::env::consts::OS.to_owned(), arch: std::env::consts::ARCH.to_owned(), cpus }
    }
}

impl RunRecord {
    /// Writes the record to a temporary file and renames it to `path`: an existing `run.json` is
    /// complete.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), RecordError> {
        json::write_checked(path, self)
    }

    /// Reads a record back.
    ///
    /// # Errors
    /// No such file, no valid JSON, a missing field, another format version, or a wrong checksum.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        json::parse_checked(&input::read(path, MOST_DATA).map_err(RecordError::io(path))?, path, RUN_SCHEMA)
    }

    /// The run's row in the summary.
    pub fn summary_row(&self) -> SummaryRow {
        SummaryRow {
            scenario: self.scenario.clone(),
            key: self.key.clone(),
            outcome: self.outcome,
            message: self.message.clone(),
            method: self.method.clone(),
            integrator: self.integrator.clone(),
            seed: self.seed,
            parameters: self.parameters.clone(),
            verdicts: self.verdicts.clone(),
            metrics: self.metrics.clone(),
            comparison: self.comparison.clone(),
            wall_s: self.timing.wall_s,
            cpu_s: self.timing.cpu_s,
            real_time_factor: self.metrics.duration_s / self.timing.wall_s,
            repeats: self.timing.repeats,
            avoidance: self.timing.avoidance,
        }
    }
}

/// Serializes an outcome by its name.
mod outcome {
    use super::*;

    pub fn serialize<S: Serializer>(value: &Outcome, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(value.name())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Outcome, D::Error> {
        let name = String::deserialize(deserializer)?;
        let found = Outcome::ALL.into_iter().find(|o| o.name() == name);
        found.ok_or_else(|| D::Error::custom(format!("unknown outcome `{name}`")))
    }
}
