//! The columns of the summary: names, order and where each value comes from. These names are the user's contract.

use crate::results::{Comparison, Measure, ParamValue, Repeats, Verdict};
use crate::sim::{AvoidanceTime, Metrics, Outcome};

/// One run in the summary.
#[derive(Clone, Debug, PartialEq)]
pub struct SummaryRow {
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// How it ended.
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
    /// What was expected of it, and what came of it; no column.
    pub verdicts: Vec<Verdict>,
    /// What was measured.
    pub metrics: Metrics,
    /// How far it is from what it was compared with.
    pub comparison: Comparison,
    /// Wall-clock time, s.
    pub wall_s: f64,
    /// Processor time, s.
    pub cpu_s: f64,
    /// Simulated over wall-clock time.
    pub real_time_factor: f64,
    /// Times of its repetitions, if there were any.
    pub repeats: Option<Repeats>,
    /// Processor time that avoidance of self-collision took, where there was any.
    pub avoidance: Option<AvoidanceTime>,
}

impl SummaryRow {
    /// Did it end in a way it should not: an expectation did not hold, or it did not finish and nobody expected that?
    pub fn is_refused(&self) -> bool {
        let expected = || !self.verdicts.is_empty() && self.verdicts.iter().all(|v| v.held);
        self.outcome == Outcome::Failed || !(matches!(self.outcome, Outcome::Passed | Outcome::Fallen) || expected())
    }
}

/// A value of the summary that is a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Number {
    /// A count.
    Count(u64),
    /// A measure; `None` is an empty cell.
    Real(Option<f64>),
}

/// A numeric column.
pub(crate) struct Column {
    pub name: &'static str,
    /// Of counts, else of measures.
    pub counts: bool,
    pub get: fn(&SummaryRow) -> Number,
}

impl Column {
    /// Its cell of a row: empty where the run could not measure it.
    pub fn of(&self, row: &SummaryRow) -> Number {
        if row.metrics.elsewhere && !FELT.iter().any(|known| self.name.starts_with(known)) {
            return Number::Real(None);
        }
        (self.get)(row)
    }
}

/// Columns, by the beginnings of their names, of runs whose robot was somewhere else: what follows from sensing and from what was
/// asked. The rest is known to who simulates alone.
const FELT: [&str; 13] = [
    "duration_s",
    "wall_",
    "cpu_",
    "real_time_factor",
    "final_base_",
    "final_com_",
    "first_fall_s",
    "min_self_distance_m",
    "self_collisions",
    "self_near_s",
    "avoidance_",
    "timing_",
    "error_",
];

/// A column of text.
pub(crate) struct TextColumn {
    pub name: &'static str,
    pub get: fn(&SummaryRow) -> &str,
}

/// Columns before the swept parameters that hold text; `seed` follows them.
pub(crate) const TEXT_COLUMNS: &[TextColumn] = &[
    TextColumn { name: "scenario", get: |r| &r.scenario },
    TextColumn { name: "key", get: |r| &r.key },
    TextColumn { name: "outcome", get: |r| r.outcome.name() },
    TextColumn { name: "message", get: |r| &r.message },
    TextColumn { name: "method", get: |r| &r.method },
    TextColumn { name: "integrator", get: |r| &r.integrator },
];

macro_rules! columns {
    ($($name:literal $kind:ident |$r:ident| $value:expr;)*) => {
        &[$(Column {
            name: $name,
            counts: stringify!($kind).as_bytes()[0] == b'C',
            get: |$r| Number::$kind($value),
        }),*]
    };
}

/// Columns after the swept parameters, all numeric, in order.
pub(crate) const COLUMNS: &[Column] = columns! {
    "duration_s" Real |r| Some(r.metrics.duration_s);
    "wall_s" Real |r| Some(r.wall_s);
    "cpu_s" Real |r| Some(r.cpu_s);
    "real_time_factor" Real |r| Some(r.real_time_factor);
    "steps" Count |r| r.metrics.steps;
    "rejected_steps" Count |r| r.metrics.rejected_steps;
    "evaluations" Count |r| r.metrics.evaluations;
    "events" Count |r| r.metrics.events;
    "state_changes" Count |r| r.metrics.state_changes;
    "states_tested_mean" Real |r| states_tested_mean(&r.metrics);
    "states_tested_max" Count |r| r.metrics.states_tested_max;
    "impacts" Count |r| r.metrics.impacts;
    "jams" Count |r| r.metrics.jams;
    "inconsistent" Count |r| r.metrics.inconsistent;
    "final_base_x" Real |r| Some(r.metrics.final_base_position[0]);
    "final_base_y" Real |r| Some(r.metrics.final_base_position[1]);
    "final_base_z" Real |r| Some(r.metrics.final_base_position[2]);
    "final_base_roll" Real |r| Some(r.metrics.final_base_rpy[0]);
    "final_base_pitch" Real |r| Some(r.metrics.final_base_rpy[1]);
    "final_base_yaw" Real |r| Some(r.metrics.final_base_rpy[2]);
    "final_base_vx" Real |r| Some(r.metrics.final_base_velocity[0]);
    "final_base_vy" Real |r| Some(r.metrics.final_base_velocity[1]);
    "final_base_vz" Real |r| Some(r.metrics.final_base_velocity[2]);
    "max_penetration_m" Real |r| Some(r.metrics.max_penetration_m);
    "max_static_creep_m" Real |r| Some(r.metrics.max_static_creep_m);
    "max_lift_m" Real |r| Some(r.metrics.max_lift_m);
    "max_cone_excess" Real |r| Some(r.metrics.max_cone_excess);
    "energy_error_J" Real |r| Some(r.metrics.energy_error_j);
    // Filled by a comparison with a reference run, and empty without one.
    "error_position_rms_m" Real |r| r.comparison.error_position_rms_m;
    "error_joint_rms_rad" Real |r| r.comparison.error_joint_rms_rad;
    "error_force_rms_N" Real |r| r.comparison.error_force_rms_n;
    "contact_state_agreement" Real |r| r.comparison.contact_state_agreement;
    "first_touchdown_s" Real |r| r.metrics.first_touchdown_s;
    "first_liftoff_s" Real |r| r.metrics.first_liftoff_s;
    "first_slip_s" Real |r| r.metrics.first_slip_s;
    "first_stick_s" Real |r| r.metrics.first_stick_s;
    "first_fall_s" Real |r| r.metrics.first_fall_s;
    "max_projection_m" Real |r| Some(r.metrics.max_projection_m);
    "rms_penetration_m" Real |r| Some(r.metrics.rms_penetration_m);
    "max_tension_N" Real |r| Some(r.metrics.max_tension_n);
    "rms_tension_N" Real |r| Some(r.metrics.rms_tension_n);
    "max_signorini_Nm" Real |r| Some(r.metrics.max_signorini_nm);
    "rms_signorini_Nm" Real |r| Some(r.metrics.rms_signorini_nm);
    "rms_cone_excess_N" Real |r| Some(r.metrics.rms_cone_excess_n);
    "max_dissipation_gap_W" Real |r| Some(r.metrics.max_dissipation_gap_w);
    "rms_dissipation_gap_W" Real |r| Some(r.metrics.rms_dissipation_gap_w);
    "max_creep_speed_m_per_s" Real |r| Some(r.metrics.max_creep_speed_m_per_s);
    "rms_creep_speed_m_per_s" Real |r| Some(r.metrics.rms_creep_speed_m_per_s);
    "max_resultant_gap_N" Real |r| Some(r.metrics.max_resultant_gap_n);
    "force_flickers" Count |r| r.metrics.force_flickers;
    "max_energy_error_J" Real |r| Some(r.metrics.max_energy_error_j);
    "rms_energy_error_J" Real |r| Some(r.metrics.rms_energy_error_j);
    "energy_change_J" Real |r| Some(r.metrics.energy_change_j);
    "actuator_work_J" Real |r| Some(r.metrics.actuator_work_j);
    "external_work_J" Real |r| Some(r.metrics.external_work_j);
    "joint_loss_J" Real |r| Some(r.metrics.joint_loss_j);
    "friction_loss_J" Real |r| Some(r.metrics.friction_loss_j);
    "impact_loss_J" Real |r| Some(r.metrics.impact_loss_j);
    "final_base_wx_rad_s" Real |r| Some(r.metrics.final_base_angular_velocity[0]);
    "final_base_wy_rad_s" Real |r| Some(r.metrics.final_base_angular_velocity[1]);
    "final_base_wz_rad_s" Real |r| Some(r.metrics.final_base_angular_velocity[2]);
    "final_com_x_m" Real |r| Some(r.metrics.final_com_position[0]);
    "final_com_y_m" Real |r| Some(r.metrics.final_com_position[1]);
    "final_com_z_m" Real |r| Some(r.metrics.final_com_position[2]);
    "final_com_vx_m_s" Real |r| Some(r.metrics.final_com_velocity[0]);
    "final_com_vy_m_s" Real |r| Some(r.metrics.final_com_velocity[1]);
    "final_com_vz_m_s" Real |r| Some(r.metrics.final_com_velocity[2]);
    "final_base_shift_m" Real |r| Some(r.metrics.final_base_shift_m);
    "final_base_sideways_m" Real |r| r.metrics.final_base_sideways_m;
    "final_normal_force_N" Real |r| r.metrics.final_normal_force_n;
    "final_cop_offset_m" Real |r| r.metrics.final_cop_offset_m;
    "first_tip_s" Real |r| r.metrics.first_tip_s;
    "last_impact_s" Real |r| r.metrics.last_impact_s;
    "first_impact_speed_ratio" Real |r| r.metrics.first_impact_speed_ratio;
    "max_flight_path_drift_m" Real |r| Some(r.metrics.max_flight_path_drift_m);
    "max_flight_spin_drift_Nms" Real |r| Some(r.metrics.max_flight_spin_drift_nms);
    "max_estimate_error_m" Real |r| r.metrics.max_estimate_error_m;
    "max_estimate_error_rad" Real |r| r.metrics.max_estimate_error_rad;
    "final_estimate_error_m" Real |r| r.metrics.final_estimate_error_m;
    "final_estimate_error_rad" Real |r| r.metrics.final_estimate_error_rad;
    "min_self_distance_m" Real |r| r.metrics.min_self_distance_m;
    "self_collisions" Real |r| r.metrics.self_collisions.map(|n| n as f64);
    "self_near_s" Real |r| r.metrics.self_near_s;
    "avoidance_cycles" Real |r| r.metrics.avoidance_cycles.map(|n| n as f64);
    "avoidance_early_cycles" Real |r| r.metrics.avoidance_early_cycles.map(|n| n as f64);
    "avoidance_blocked_cycles" Real |r| r.metrics.avoidance_blocked_cycles.map(|n| n as f64);
    "avoidance_tests_mean" Real |r| r.metrics.avoidance_tests_mean;
    "avoidance_tests_max" Real |r| r.metrics.avoidance_tests_max.map(|n| n as f64);
    "avoidance_held_share" Real |r| r.metrics.avoidance_held_share;
    "avoidance_rms_deviation" Real |r| r.metrics.avoidance_rms_deviation;
    "avoidance_max_deviation" Real |r| r.metrics.avoidance_max_deviation;
    "error_final_position_m" Real |r| r.comparison.error_final_position_m;
    "error_final_rotation_rad" Real |r| r.comparison.error_final_rotation_rad;
    "timing_wall_min_s" Real |r| r.repeats.map(|t| t.wall_min_s);
    "timing_wall_median_s" Real |r| r.repeats.map(|t| t.wall_median_s);
    "timing_cpu_min_s" Real |r| r.repeats.map(|t| t.cpu_min_s);
    "timing_cpu_median_s" Real |r| r.repeats.map(|t| t.cpu_median_s);
    "avoidance_cpu_s" Real |r| r.avoidance.map(|a| a.total_s);
    "avoidance_cycles_cpu_s" Real |r| r.avoidance.map(|a| a.cycles_s);
};

/// Candidates tested per selection; empty when there was no selection.
fn states_tested_mean(m: &Metrics) -> Option<f64> {
    m.states_tested_mean()
}

/// Names of the columns that [`metric`] knows, in the summary's order.
pub const NUMERIC_COLUMNS: [&str; COLUMNS.len()] = {
    let mut names = [""; COLUMNS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = COLUMNS[i].name;
        i += 1;
    }
    names
};

/// The value of a numeric column, by its name in [`NUMERIC_COLUMNS`] or in [`truth_columns`]; `None` for another name and
/// for an empty cell (a first-time mark of what never happened).
pub fn metric(row: &SummaryRow, column: &str) -> Option<f64> {
    let Some(fixed) = COLUMNS.iter().find(|c| c.name == column) else { return truth_error(row, column) };
    match fixed.of(row) {
        Number::Count(n) => Some(n as f64),
        Number::Real(x) => x,
    }
}

/// The same as other programs are told it.
pub fn measure(row: &SummaryRow, column: &str) -> Measure {
    match COLUMNS.iter().find(|c| c.name == column).map(|c| c.of(row)) {
        Some(Number::Count(n)) => Measure::Count(n),
        Some(Number::Real(x)) => x.map_or(Measure::Nothing, Measure::Real),
        None => truth_error(row, column).map_or(Measure::Nothing, Measure::Real),
    }
}

/// Names of the columns `error_METRIC` that stand last in the summary, one for each metric of any row whose truth is
/// known, in the order they are first met.
pub fn truth_columns(rows: &[SummaryRow]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for truth in rows.iter().flat_map(|r| &r.comparison.truth) {
        let name = truth.column();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The distance from a truth, by the name of its column.
pub(crate) fn truth_error(row: &SummaryRow, column: &str) -> Option<f64> {
    let metric = column.strip_prefix("error_")?;
    row.comparison.truth.iter().find(|t| t.metric == metric)?.error
}
