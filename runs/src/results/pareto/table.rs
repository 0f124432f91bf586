//! The Pareto table at the end of a batch.

use crate::results::is_truth;
use crate::results::pareto::{Group, Work, error_columns, front_as_shown, groups};
use crate::results::table::clip;
use crate::results::verdict_table::brief_parameters;
use crate::text::text_table::{Alignment, TextTable, limited};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Largest number of lines of a group. Larger groups show the runs on a front and the best of
/// each curve.
const MAX_LINES: usize = 30;

/// Largest number of groups; the report has all groups.
const MAX_GROUPS: usize = 12;

/// A block per group of comparable runs, sorted by cost: method, parameters, errors and cost, with
/// a mark at errors on the Pareto front. Empty when no run has an error column.
pub fn pareto_table(works: &[Work], width: usize) -> String {
    let mut out = String::new();
    let measured = |group: &Group| group.rows().any(|i| !works[i].errors.is_empty());
    let groups: Vec<Group> = groups(works).into_iter().filter(measured).collect();
    for group in groups.iter().take(MAX_GROUPS) {
        // A String takes every write.
        let _ = writeln!(out, "{}", limited(group.name()));
        out += &block(works, group, width);
        out.push('\n');
    }
    if groups.is_empty() {
        return out;
    }
    if let more @ 1.. = groups.len().saturating_sub(MAX_GROUPS) {
        let _ = writeln!(out, "{more} more groups are in the report");
    }
    out += "* on the Pareto front: no other run of the group is both cheaper and more accurate\n";
    out
}

/// A run in its group: the columns of a line, without its numbers.
struct Line {
    row: usize,
    cost: f64,
    /// Per error column its size and whether it is on the front; none where it has none.
    errors: Vec<Option<(f64, bool)>>,
}

fn block(works: &[Work], group: &Group, width: usize) -> String {
    let members: Vec<Work> = group.rows().map(|i| works[i].clone()).collect();
    let columns = error_columns(&members);
    let (lines, without) = lines(works, group, &columns);
    let listed = choose(&lines, group);
    let parameters = varying(works, group);
    let text = ["method", "integrator"].into_iter().chain((!parameters.is_empty()).then_some("parameters"));
    let text = text.map(|name| (name.to_owned(), Alignment::Left));
    // A mark follows each error, and a space follows its name.
    let errors = columns.iter().map(|c| format!("{c} "));
    let numbers = errors.chain(["cpu s / sim s", "x real time"].map(String::from)).map(|name| (name, Alignment::Right));
    let mut table = TextTable::new(text.chain(numbers));
    let cells = |line: &Line| -> Vec<String> {
        let row = works[line.row].row;
        let own = (!parameters.is_empty()).then(|| brief_parameters(row, |name| parameters.iter().any(|p| p == name)));
        let error = |e: &Option<(f64, bool)>| match e {
            Some((error, on)) => {
                let number = if *error == 0.0 { "0".to_owned() } else { format!("{error:.2e}") };
                format!("{number}{}", if *on { '*' } else { ' ' })
            }
            None => "- ".to_owned(),
        };
        [clip(&row.method), clip(&row.integrator)]
            .into_iter()
            .chain(own)
            .chain(line.errors.iter().map(error))
            .chain([format!("{:.2e}", line.cost), real_time(works[line.row].real_time_factor)])
            .collect()
    };
    listed.iter().for_each(|line| table.push(cells(line)));
    let mut out = table.render(width);
    if let more @ 1.. = lines.len() - listed.len() {
        let _ = writeln!(out, "{more} more are in the report and the summary");
    }
    for (reason, count) in without {
        let _ = writeln!(out, "{count} left out: {reason}");
    }
    out
}

/// A dash where the time is unknown.
fn real_time(factor: f64) -> String {
    if factor.is_nan() { "-".to_owned() } else { format!("{factor:.1}") }
}

/// The lines of a group by cost, and how many runs have no point at all, by reason.
fn lines(works: &[Work], group: &Group, columns: &[String]) -> (Vec<Line>, Vec<(String, usize)>) {
    let mut lines = Vec::new();
    let mut without: Vec<(String, usize)> = Vec::new();
    for row in group.rows() {
        let points: Vec<_> = columns.iter().map(|c| works[row].point(c)).collect();
        match points.iter().find_map(|p| p.as_ref().ok()) {
            Some(&(cost, _)) => {
                let errors = points.into_iter().map(|p| p.ok().map(|(_, error)| (error, false))).collect();
                lines.push(Line { row, cost, errors });
            }
            None => {
                let reason = points.into_iter().find_map(Result::err).map(|r| r.to_string()).unwrap_or_default();
                match without.iter_mut().find(|(r, _)| *r == reason) {
                    Some((_, count)) => *count += 1,
                    None => without.push((reason, 1)),
                }
            }
        }
    }
    lines.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    for column in 0..columns.len() {
        let point = |l: &Line| (l.cost, l.errors[column].map_or(f64::NAN, |(error, _)| error));
        let on = front_as_shown(&lines.iter().map(point).collect::<Vec<_>>());
        for (line, on) in lines.iter_mut().zip(on) {
            line.errors[column].iter_mut().for_each(|(_, mark)| *mark = on);
        }
    }
    (lines, without)
}

/// All lines if they are few; else those on a front and the most accurate of each curve, at most
/// [`MAX_LINES`], the cheapest first.
fn choose<'a>(lines: &'a [Line], group: &Group) -> Vec<&'a Line> {
    if lines.len() <= MAX_LINES {
        return lines.iter().collect();
    }
    let first_error = |l: &&Line| l.errors.iter().flatten().map(|(error, _)| *error).next().unwrap_or(f64::INFINITY);
    let best = |curve: &crate::results::pareto::Curve| {
        let own = lines.iter().filter(|l| curve.rows.contains(&l.row));
        own.min_by(|a, b| first_error(a).total_cmp(&first_error(b))).map(|l| l.row)
    };
    let best: BTreeSet<usize> = group.curves.iter().filter_map(best).collect();
    let kept = lines.iter().filter(|l| best.contains(&l.row) || l.errors.iter().flatten().any(|(_, on)| *on));
    kept.take(MAX_LINES).collect()
}

/// Swept parameters with more than one value among the group's rows; method and integrator have
/// columns of their own.
fn varying(works: &[Work], group: &Group) -> Vec<String> {
    let mut names: Vec<(&str, BTreeSet<String>)> = Vec::new();
    let rows: Vec<usize> = group.rows().collect();
    for (name, value) in rows.iter().flat_map(|&i| &works[i].row.parameters) {
        let value = value.to_string();
        match names.iter_mut().find(|(n, _)| n == name) {
            Some((_, values)) => {
                values.insert(value);
            }
            None => names.push((name, BTreeSet::from([value]))),
        }
    }
    let shared = |name: &str| rows.iter().all(|&i| works[i].row.parameters.iter().any(|(n, _)| n == name));
    let own = |name: &str| ["contact.method", "integrator.method"].contains(&name) || is_truth(name);
    let kept = names.into_iter().filter(|(name, values)| !own(name) && (values.len() > 1 || !shared(name)));
    kept.map(|(name, _)| name.to_owned()).collect()
}
