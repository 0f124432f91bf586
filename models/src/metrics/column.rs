//! Numeric columns of the summary, derived from the table of metrics.

use super::number::Measure;
use super::table::{Metrics, ROWS};

/// Runs for which a metric is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// Simulations and the control side of a remote robot: it follows from sensing and commands.
    Robot,
    /// Simulations only; not measured when the robot runs in another process.
    Simulation,
}

/// Costs of a run, from `timing` of its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Wall-clock time, s.
    Wall,
    /// Processor time, s.
    Cpu,
    /// Simulated time per wall-clock time.
    RealTimeFactor,
    /// Least wall-clock time of repeated runs, s.
    RepeatedWallMin,
    /// Median wall-clock time of repeated runs, s.
    RepeatedWallMedian,
    /// Least processor time of repeated runs, s.
    RepeatedCpuMin,
    /// Median processor time of repeated runs, s.
    RepeatedCpuMedian,
    /// Processor time of collision avoidance, s.
    Avoidance,
    /// Of this, in ticks with a cycle, s.
    AvoidanceCycles,
}

impl Cost {
    /// Whether every run has it, so that `[[expect]]` may name it.
    const fn is_always_measured(self) -> bool {
        matches!(self, Cost::Wall | Cost::Cpu | Cost::RealTimeFactor)
    }
}

/// Distances of a run from its reference run, from `comparison` of its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// Root mean square distance of the base, m.
    PositionRms,
    /// Root mean square difference of the joint positions, rad or m.
    JointRms,
    /// Root mean square difference of the contact forces, N.
    ForceRms,
    /// Share of equal contact states, over instants and soles.
    StateAgreement,
    /// Distance of the base at the last instant that both reached, m.
    FinalPosition,
    /// Angle between the bases at the last instant that both reached, rad.
    FinalRotation,
    /// Root mean square distance of the objects, m.
    ObjectPositionRms,
    /// Root mean square difference of the positions of the objects' joints, rad or m.
    ObjectJointRms,
    /// Largest distance of an object at the last instant that both reached, m.
    FinalObjectPosition,
}

/// Source of the values of a column.
#[derive(Clone, Copy)]
pub enum ColumnSource {
    /// The metrics of the run; the second argument is the column's index within its row of the
    /// table.
    Metrics(fn(&Metrics, usize) -> Measure),
    /// A cost.
    Cost(Cost),
    /// A distance.
    Distance(Distance),
}

/// A row of the table of metrics.
pub(super) struct MetricRow {
    pub columns: &'static [&'static str],
    pub unit: &'static str,
    pub meaning: &'static str,
    pub known: Known,
    pub is_count: bool,
    pub source: ColumnSource,
}

/// A numeric column of the summary.
#[derive(Clone, Copy)]
pub struct Column {
    /// Name in summaries, `[[expect]]` and `[[claim]]`.
    pub name: &'static str,
    /// The runs that have it.
    pub known: Known,
    /// Whether it contains whole numbers.
    pub is_count: bool,
    /// Where its values come from.
    pub source: ColumnSource,
    /// Index within its row of the table.
    pub axis: usize,
    /// Unit; empty for counts and ratios.
    pub unit: &'static str,
}

const COLUMN_COUNT: usize = {
    let (mut count, mut row) = (0, 0);
    while row < ROWS.len() {
        count += ROWS[row].columns.len();
        row += 1;
    }
    count
};

/// All numeric columns, in the summary's order; they follow the swept parameters.
pub const COLUMNS: [Column; COLUMN_COUNT] = {
    let MetricRow { known, is_count, source, unit, .. } = ROWS[0];
    let mut columns = [Column { name: "", known, is_count, source, axis: 0, unit }; COLUMN_COUNT];
    let (mut next, mut row) = (0, 0);
    while row < ROWS.len() {
        let MetricRow { columns: names, known, is_count, source, unit, .. } = ROWS[row];
        let mut axis = 0;
        while axis < names.len() {
            columns[next] = Column { name: names[axis], known, is_count, source, axis, unit };
            next += 1;
            axis += 1;
        }
        row += 1;
    }
    columns
};

/// Names of the numeric columns, in the summary's order.
pub const NUMERIC_COLUMNS: [&str; COLUMN_COUNT] = {
    let mut names = [""; COLUMN_COUNT];
    let mut i = 0;
    while i < COLUMN_COUNT {
        names[i] = COLUMNS[i].name;
        i += 1;
    }
    names
};

impl Column {
    const fn is_expectable(&self) -> bool {
        match self.source {
            ColumnSource::Metrics(_) | ColumnSource::Distance(_) => true,
            ColumnSource::Cost(cost) => cost.is_always_measured(),
        }
    }

    /// Whether it is a cost in time.
    pub fn is_cost(&self) -> bool {
        matches!(self.source, ColumnSource::Cost(_))
    }

    /// Whether it is a measured quantity of the run's physics or computation, whose truth may be
    /// known.
    pub fn is_metric(&self) -> bool {
        matches!(self.source, ColumnSource::Metrics(_))
    }
}

/// A numeric column by its name.
pub fn column(name: &str) -> Option<&'static Column> {
    static ALL: [Column; COLUMN_COUNT] = COLUMNS;
    ALL.iter().find(|column| column.name == name)
}

/// Whether the column is a distance from the reference run, which a run without a reference lacks.
pub fn is_distance(name: &str) -> bool {
    column(name).is_some_and(|column| matches!(column.source, ColumnSource::Distance(_)))
}

/// The unit of a column or of its error; empty for counts and ratios.
pub fn unit(name: &str) -> &'static str {
    let of_error = || column(name.strip_prefix("error_")?);
    column(name).or_else(of_error).map_or("", |column| column.unit)
}

/// Whether the name of a column ends with its unit, such as `_rad_s` or `_m_per_s`.
pub fn names_unit(name: &str) -> bool {
    let compact = unit(name).replace(' ', "");
    let suffixes = ["_", "_per_"].map(|slash| format!("_{}", compact.replace('/', slash)));
    !compact.is_empty() && suffixes.iter().any(|suffix| name.ends_with(suffix))
}

const EXPECTABLE_COUNT: usize = {
    let (mut count, mut i) = (0, 0);
    while i < COLUMN_COUNT {
        count += COLUMNS[i].is_expectable() as usize;
        i += 1;
    }
    count
};

impl Metrics {
    /// The value of a numeric column of the summary; nothing for other columns and for what this run did
    /// not measure.
    pub fn measure(&self, name: &str) -> Measure {
        match column(name).map(|column| (column.source, column.axis)) {
            Some((ColumnSource::Metrics(get), axis)) => get(self, axis),
            _ => Measure::Nothing,
        }
    }
}

/// Names that `[[expect]]` accepts, in the summary's order.
pub const METRICS: &[&str] = &{
    let mut names = [""; EXPECTABLE_COUNT];
    let (mut next, mut i) = (0, 0);
    while i < COLUMN_COUNT {
        if COLUMNS[i].is_expectable() {
            names[next] = COLUMNS[i].name;
            next += 1;
        }
        i += 1;
    }
    names
};

/// The table of columns for `docs/results.md`, as Markdown.
pub fn column_reference() -> String {
    let mut page = String::from("| column | unit | meaning |\n|---|---|---|\n");
    for row in ROWS.iter().filter(|row| !row.columns.is_empty()) {
        let names = row.columns.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        page += &format!("| {names} | {} | {} |\n", row.unit, row.meaning.replace('|', "\\|"));
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_the_units_of_their_metrics() {
        for (name, expected, is_named) in [
            ("error_position_rms_m", "m", true),
            ("error_final_base_x", "m", false),
            ("error_final_base_vz", "m/s", false),
            ("error_force_rms_N", "N", true),
            ("error_final_base_yaw", "rad", false),
            ("max_creep_speed_m_per_s", "m/s", true),
            ("final_com_vx_m_s", "m/s", true),
            ("final_base_wx_rad_s", "rad/s", true),
            ("max_flight_spin_drift_Nms", "N m s", true),
            ("max_signorini_Nm", "N m", true),
            ("rms_dissipation_gap_W", "W", true),
            ("max_cone_excess", "N", false),
            ("energy_error_J", "J", true),
            ("force_flickers", "", false),
            ("error_impacts", "", false),
            ("first_impact_speed_ratio", "", false),
        ] {
            assert_eq!((unit(name), names_unit(name)), (expected, is_named), "{name}");
        }
    }
}
