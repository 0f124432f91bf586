//! The table of residuals of contact laws and energy balance, with the greatest of each scenario
//! marked.

use crate::report::ReportRun;
use crate::report::labels::parameters;
use crate::report::table::{Cell, Head, Part, Table, bounded};
use crate::results::metric;

/// Columns of the summary; greater values are worse.
const COLUMNS: [&str; 14] = [
    "max_penetration_m",
    "rms_penetration_m",
    "max_static_creep_m",
    "max_creep_speed_m_per_s",
    "max_cone_excess",
    "rms_cone_excess_N",
    "max_tension_N",
    "max_signorini_Nm",
    "max_dissipation_gap_W",
    "max_resultant_gap_N",
    "max_energy_error_J",
    "rms_energy_error_J",
    "force_flickers",
    "inconsistent",
];

pub(super) fn residuals(runs: &[ReportRun]) -> Table {
    let (listed, more) = bounded(runs);
    let head = ["parameters", "method", "integrator"].map(Head::text).into_iter();
    let mut table =
        Table { head: head.chain(COLUMNS.iter().map(|c| Head::column(c))).collect(), parts: Vec::new(), more };
    for part in listed.chunk_by(|&a, &b| runs[a].row.scenario == runs[b].row.scenario) {
        let worst = COLUMNS.map(|column| worst(part.iter().filter_map(|&i| metric(runs[i].row, column))));
        let row = |&i: &usize| {
            let row = runs[i].row;
            let texts =
                [Cell::text(parameters(row).join(" ")), Cell::unbroken(&row.method), Cell::unbroken(&row.integrator)];
            let number = |(column, worst): (&&str, &Option<f64>)| cell(metric(row, column), *worst);
            texts.into_iter().chain(COLUMNS.iter().zip(&worst).map(number)).collect()
        };
        table.parts.push(Part { title: runs[part[0]].row.scenario.clone(), rows: part.iter().map(row).collect() });
    }
    table
}

/// Values below this are rounding, in any of the units, and not ranked.
const ROUNDING: f64 = 1e-12;

/// The greatest value, unless all are equal.
fn worst(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for size in values.map(f64::abs).filter(|v| v.is_finite()) {
        (least, most) = (least.min(size), most.max(size));
    }
    (most > least && most > ROUNDING).then_some(most)
}

fn cell(value: Option<f64>, worst: Option<f64>) -> Cell {
    let class = match value {
        Some(x) if !x.is_finite() => "n bad",
        Some(x) if Some(x.abs()) == worst => "n worst",
        _ => "n",
    };
    Cell { class, ..Cell::number(value) }
}
