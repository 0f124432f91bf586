//! `run.json`: what one run was, how it ended and what it measured.

use crate::files::input::{self, MOST_DATA};
use crate::files::{RecordError, atomic};
use crate::results::{Comparison, LeftLog, ParamValue, Repeats, SummaryRow, Verdict, number};
use crate::sim::{AvoidanceTime, Metrics, Outcome};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::io::Write;
use std::path::Path;

/// Format version of `run.json`.
pub const RUN_SCHEMA: u32 = 1;

/// This program and its version, as records name them.
pub const PROGRAM: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// Which build of it this is: a hash of its sources.
pub const BUILD: &str = env!("STICTION_BUILD");

/// The record of one finished run. Everything but `timing` depends on the run alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Format version, [`RUN_SCHEMA`].
    pub schema: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// How it ended.
    #[serde(with = "outcome")]
    pub outcome: Outcome,
    /// Why, when there is something to say.
    pub message: String,
    /// Contact method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// Seed.
    pub seed: u64,
    /// Swept parameters under their dotted names, in file order.
    pub parameters: Vec<(String, ParamValue)>,
    /// What was expected of it, and what came of it, in file order.
    pub verdicts: Vec<Verdict>,
    /// What was measured.
    #[serde(with = "MetricsRecord")]
    pub metrics: Metrics,
    /// How far it is from what it was compared with.
    #[serde(default, skip_serializing_if = "Comparison::is_empty")]
    pub comparison: Comparison,
    /// What else there is to tell a person.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Program and version.
    pub program: String,
    /// Files the run was made of.
    pub inputs: Vec<InputHash>,
    /// The resolved scenario, as TOML.
    pub resolved: String,
    /// The log that it left; none if it left none, or was made by an earlier version, which did not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<LeftLog>,
    /// What depends on the machine and the moment.
    pub timing: Timing,
}

/// A file a run was made of.
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

/// Times and the machine they were taken on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Wall-clock time, s.
    #[serde(with = "number::real")]
    pub wall_s: f64,
    /// Processor time, s.
    #[serde(with = "number::real")]
    pub cpu_s: f64,
    /// Where.
    pub machine: Machine,
    /// The scenario file as it was named: relative paths in [`RunRecord::resolved`] begin at its folder. Records of earlier
    /// versions do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The build of the program, [`BUILD`]: no part of the key, since most changes of the sources change no result. Records of
    /// earlier versions do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build: Option<String>,
    /// Times of its repetitions, if there were any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<Repeats>,
    /// Of the processor time, what avoidance of self-collision took.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub avoidance: Option<AvoidanceTime>,
}

/// The machine a run was made on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Operating system.
    pub os: String,
    /// Processor architecture.
    pub arch: String,
    /// Processors this program may use.
    pub cpus: usize,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        Self {
            os: std::env::consts::OS.to_owned(),
            arch: std::env::consts::ARCH.to_owned(),
            cpus: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

impl RunRecord {
    /// Writes the record beside `path` and renames it there; a `run.json` that exists is complete.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), RecordError> {
        atomic::write(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self)
                .map_err(|source| RecordError::Json { path: path.to_owned(), source })?;
            out.write_all(b"\n").map_err(RecordError::io(path))
        })
    }

    /// Reads a record back.
    ///
    /// # Errors
    /// No such file, no JSON, a field missing, or another format version.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        /// The version is looked at first: another one may have other fields.
        #[derive(Deserialize)]
        struct Version {
            schema: u64,
        }
        let json = |source| RecordError::Json { path: path.to_owned(), source };
        let bytes = input::read(path, MOST_DATA).map_err(RecordError::io(path))?;
        let Version { schema } = serde_json::from_slice(&bytes).map_err(json)?;
        if schema != u64::from(RUN_SCHEMA) {
            return Err(RecordError::Version { path: path.to_owned(), found: schema, expected: RUN_SCHEMA });
        }
        serde_json::from_slice(&bytes).map_err(json)
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

/// An outcome as its word in the summary.
mod outcome {
    use super::*;

    pub fn serialize<S: Serializer>(value: &Outcome, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(value.name())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Outcome, D::Error> {
        let word = String::deserialize(deserializer)?;
        let found = Outcome::ALL.into_iter().find(|o| o.name() == word);
        found.ok_or_else(|| D::Error::custom(format!("unknown outcome `{word}`")))
    }
}

/// [`Metrics`] in JSON; the compiler checks that no field is forgotten.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Metrics")]
struct MetricsRecord {
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    elsewhere: bool,
    #[serde(with = "number::real")]
    duration_s: f64,
    steps: u64,
    rejected_steps: u64,
    evaluations: u64,
    events: u64,
    state_changes: u64,
    selections: u64,
    states_tested: u64,
    #[serde(default)]
    confirmed: u64,
    states_tested_max: u64,
    impacts: u64,
    jams: u64,
    inconsistent: u64,
    #[serde(with = "number::triple")]
    final_base_position: [f64; 3],
    #[serde(with = "number::triple")]
    final_base_rpy: [f64; 3],
    #[serde(with = "number::triple")]
    final_base_velocity: [f64; 3],
    #[serde(with = "number::real")]
    max_penetration_m: f64,
    #[serde(with = "number::real")]
    max_static_creep_m: f64,
    #[serde(with = "number::real")]
    max_projection_m: f64,
    #[serde(with = "number::real")]
    max_lift_m: f64,
    #[serde(with = "number::real")]
    max_cone_excess: f64,
    #[serde(with = "number::real", rename = "energy_error_J")]
    energy_error_j: f64,
    first_touchdown_s: Option<f64>,
    first_liftoff_s: Option<f64>,
    first_slip_s: Option<f64>,
    first_stick_s: Option<f64>,
    first_fall_s: Option<f64>,
    #[serde(with = "number::real")]
    rms_penetration_m: f64,
    #[serde(with = "number::real", rename = "max_tension_N")]
    max_tension_n: f64,
    #[serde(with = "number::real", rename = "rms_tension_N")]
    rms_tension_n: f64,
    #[serde(with = "number::real", rename = "max_signorini_Nm")]
    max_signorini_nm: f64,
    #[serde(with = "number::real", rename = "rms_signorini_Nm")]
    rms_signorini_nm: f64,
    #[serde(with = "number::real", rename = "rms_cone_excess_N")]
    rms_cone_excess_n: f64,
    #[serde(with = "number::real", rename = "max_dissipation_gap_W")]
    max_dissipation_gap_w: f64,
    #[serde(with = "number::real", rename = "rms_dissipation_gap_W")]
    rms_dissipation_gap_w: f64,
    #[serde(with = "number::real")]
    max_creep_speed_m_per_s: f64,
    #[serde(with = "number::real")]
    rms_creep_speed_m_per_s: f64,
    #[serde(with = "number::real", rename = "max_resultant_gap_N")]
    max_resultant_gap_n: f64,
    force_flickers: u64,
    #[serde(with = "number::real", rename = "max_energy_error_J")]
    max_energy_error_j: f64,
    #[serde(with = "number::real", rename = "rms_energy_error_J")]
    rms_energy_error_j: f64,
    #[serde(with = "number::real", rename = "energy_change_J")]
    energy_change_j: f64,
    #[serde(with = "number::real", rename = "actuator_work_J")]
    actuator_work_j: f64,
    #[serde(with = "number::real", rename = "external_work_J")]
    external_work_j: f64,
    #[serde(with = "number::real", rename = "joint_loss_J")]
    joint_loss_j: f64,
    #[serde(with = "number::real", rename = "friction_loss_J")]
    friction_loss_j: f64,
    #[serde(with = "number::real", rename = "impact_loss_J")]
    impact_loss_j: f64,
    #[serde(with = "number::triple")]
    final_base_angular_velocity: [f64; 3],
    #[serde(with = "number::triple")]
    final_com_position: [f64; 3],
    #[serde(with = "number::triple")]
    final_com_velocity: [f64; 3],
    #[serde(with = "number::real")]
    final_base_shift_m: f64,
    #[serde(with = "number::some_real")]
    final_base_sideways_m: Option<f64>,
    #[serde(with = "number::some_real", rename = "final_normal_force_N")]
    final_normal_force_n: Option<f64>,
    #[serde(with = "number::some_real")]
    final_cop_offset_m: Option<f64>,
    first_tip_s: Option<f64>,
    last_impact_s: Option<f64>,
    #[serde(with = "number::some_real")]
    first_impact_speed_ratio: Option<f64>,
    #[serde(with = "number::real")]
    max_flight_path_drift_m: f64,
    #[serde(with = "number::real", rename = "max_flight_spin_drift_Nms")]
    max_flight_spin_drift_nms: f64,
    #[serde(default, with = "number::some_real")]
    max_estimate_error_m: Option<f64>,
    #[serde(default, with = "number::some_real")]
    max_estimate_error_rad: Option<f64>,
    #[serde(default, with = "number::some_real")]
    final_estimate_error_m: Option<f64>,
    #[serde(default, with = "number::some_real")]
    final_estimate_error_rad: Option<f64>,
    #[serde(default, with = "number::some_real")]
    min_self_distance_m: Option<f64>,
    #[serde(default)]
    self_collisions: Option<u64>,
    #[serde(default, with = "number::some_real")]
    self_near_s: Option<f64>,
    #[serde(default)]
    avoidance_cycles: Option<u64>,
    #[serde(default)]
    avoidance_early_cycles: Option<u64>,
    #[serde(default)]
    avoidance_blocked_cycles: Option<u64>,
    #[serde(default, with = "number::some_real")]
    avoidance_tests_mean: Option<f64>,
    #[serde(default)]
    avoidance_tests_max: Option<u64>,
    #[serde(default, with = "number::some_real")]
    avoidance_held_share: Option<f64>,
    #[serde(default, with = "number::some_real")]
    avoidance_rms_deviation: Option<f64>,
    #[serde(default, with = "number::some_real")]
    avoidance_max_deviation: Option<f64>,
}
