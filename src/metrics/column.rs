//! Numeric columns of the summary, derived from the table of metrics.

use super::number::Measure;
use super::table::{Metrics, ROWS};

/// Who knows a metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    /// A simulation, and the control side of a remote robot: it follows from sensing and commands.
    Robot,
    /// A simulation alone; not measured when the robot runs in another process.
    Simulation,
}

/// Costs of a run, from `timing` of its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cost {
    Wall,
    Cpu,
    RealTimeFactor,
    RepeatedWallMin,
    RepeatedWallMedian,
    RepeatedCpuMin,
    RepeatedCpuMedian,
    Avoidance,
    AvoidanceCycles,
}

impl Cost {
    /// Every run has it, so `[[expect]]` may name it.
    const fn is_always_measured(self) -> bool {
        matches!(self, Cost::Wall | Cost::Cpu | Cost::RealTimeFactor)
    }
}

/// Distances of a run from its reference run, from `comparison` of its record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Distance {
    PositionRms,
    JointRms,
    ForceRms,
    StateAgreement,
    FinalPosition,
    FinalRotation,
}

/// Where the value of a column comes from.
#[derive(Clone, Copy)]
pub(crate) enum ColumnSource {
    /// The metrics of the run; the second argument is the column's index within its row of the table.
    Metrics(fn(&Metrics, usize) -> Measure),
    Cost(Cost),
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
pub(crate) struct Column {
    pub name: &'static str,
    pub known: Known,
    /// It holds whole numbers.
    pub is_count: bool,
    pub source: ColumnSource,
    /// Index within its row of the table.
    pub axis: usize,
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
pub(crate) const COLUMNS: [Column; COLUMN_COUNT] = {
    let MetricRow { known, is_count, source, .. } = ROWS[0];
    let mut columns = [Column { name: "", known, is_count, source, axis: 0 }; COLUMN_COUNT];
    let (mut next, mut row) = (0, 0);
    while row < ROWS.len() {
        let MetricRow { columns: names, known, is_count, source, .. } = ROWS[row];
        let mut axis = 0;
        while axis < names.len() {
            columns[next] = Column { name: names[axis], known, is_count, source, axis };
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

    /// A cost in time.
    pub fn is_cost(&self) -> bool {
        matches!(self.source, ColumnSource::Cost(_))
    }

    /// A measured quantity of the run's physics or computation, whose truth may be known.
    pub fn is_metric(&self) -> bool {
        matches!(self.source, ColumnSource::Metrics(_))
    }
}

/// A numeric column by its name.
pub(crate) fn column(name: &str) -> Option<&'static Column> {
    static ALL: [Column; COLUMN_COUNT] = COLUMNS;
    ALL.iter().find(|column| column.name == name)
}

/// The column is a distance from the reference run, which a run without a reference lacks.
pub(crate) fn is_distance(name: &str) -> bool {
    column(name).is_some_and(|column| matches!(column.source, ColumnSource::Distance(_)))
}

const EXPECTABLE_COUNT: usize = {
    let (mut count, mut i) = (0, 0);
    while i < COLUMN_COUNT {
        count += COLUMNS[i].is_expectable() as usize;
        i += 1;
    }
    count
};

/// Names that `[[expect]]` takes, in the summary's order.
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
