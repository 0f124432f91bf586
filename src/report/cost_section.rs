//! The section on error over cost, per group of comparable runs.

use crate::files::RecordError;
use crate::report::cost_plot::{CurveStyles, work_precision};
use crate::report::labels::method_and_parameters;
use crate::results::pareto::{Group, Work, error_columns, groups};
use crate::text::plural::plural;
use serde::Serialize;

/// Largest number of pictures.
const MAX_PICTURES: usize = 24;
/// Approximate limit of marks in all pictures, at 300 bytes each.
const MAX_MARKS: usize = 10_000;
/// Largest number of entries of a legend.
const MAX_CURVES: usize = 40;
/// Number of omitted runs named for one reason.
const MAX_NAMED: usize = 5;

/// The section.
#[derive(Debug, Default, Serialize)]
pub(super) struct Section {
    pub groups: Vec<Pictures>,
    /// Note on omitted groups.
    pub more: String,
}

/// The pictures of a group.
#[derive(Debug, Serialize)]
pub(super) struct Pictures {
    pub name: String,
    /// Name and style of each curve.
    pub legend: Vec<(String, String)>,
    pub more_curves: usize,
    /// Column and picture.
    pub pictures: Vec<(String, String)>,
    /// Runs that lack a mark in some picture, with the reason.
    pub left_out: Vec<String>,
}

pub(super) fn sections(works: &[Work]) -> Result<Section, RecordError> {
    let mut section = Section::default();
    let (mut pictures, mut marks, mut omitted) = (0, 0, 0);
    for group in groups(works) {
        let members: Vec<Work> = group.rows().map(|i| works[i].clone()).collect();
        let columns = error_columns(&members);
        if columns.is_empty() {
            continue;
        }
        if pictures > 0 && (pictures + columns.len() > MAX_PICTURES || marks > MAX_MARKS) {
            omitted += 1;
            continue;
        }
        pictures += columns.len();
        marks += columns.len() * members.len();
        section.groups.push(draw(works, &group, &columns)?);
    }
    if omitted > 0 {
        section.more =
            format!("{} more without pictures here; their errors are in the table of runs", plural(omitted, "group"));
    }
    Ok(section)
}

fn draw(works: &[Work], group: &Group, columns: &[String]) -> Result<Pictures, RecordError> {
    let styles = CurveStyles::of(group);
    let mut pictures = Vec::new();
    for column in columns {
        if let Some(svg) = work_precision(works, group, column, &styles)? {
            pictures.push((column.clone(), svg));
        }
    }
    let mut legend = styles.legend();
    let more_curves = legend.len().saturating_sub(MAX_CURVES);
    legend.truncate(MAX_CURVES);
    let left_out = left_out(works, group, columns);
    Ok(Pictures { name: group.name(), legend, more_curves, pictures, left_out })
}

/// `error_force_rms_N: 3 runs, no error was measured: ...`
fn left_out(works: &[Work], group: &Group, columns: &[String]) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<usize>)> = Vec::new();
    for column in columns {
        for row in group.rows() {
            let Err(reason) = works[row].point(column) else { continue };
            let reason = format!("{column}: {reason}");
            match reasons.iter_mut().find(|(r, _)| *r == reason) {
                Some((_, rows)) => rows.push(row),
                None => reasons.push((reason, vec![row])),
            }
        }
    }
    let line = |(reason, rows): (String, Vec<usize>)| {
        let mut names: Vec<String> =
            rows.iter().take(MAX_NAMED).map(|&i| method_and_parameters(works[i].row)).collect();
        if rows.len() > MAX_NAMED {
            names.push(format!("and {} more", rows.len() - MAX_NAMED));
        }
        format!("{reason} ({}): {}", plural(rows.len(), "run"), names.join("; "))
    };
    reasons.into_iter().map(line).collect()
}
