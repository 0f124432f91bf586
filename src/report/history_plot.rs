//! Draws a metric over the results of a history: the values of a single run, or of several runs, whose
//! values may be far apart, the changes since the first one.

use crate::files::RecordError;
use crate::history::{Curve, MetricCurves};
use crate::report::axis::{Axis, linear};
use crate::report::canvas::{Area, DrawError, Mark, Overlay, picture};
use crate::report::chart::{Side, Space, chart};
use crate::report::labels::short;
use crate::report::palette;
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Width and height, pixels.
const SIZE: (u32, u32) = (560, 240);

/// Greatest number of labelled results.
const MAX_LABELS: usize = 6;

/// Longest label of a result, characters.
const LABEL_LENGTH: usize = 16;

/// Draws a metric.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn history_plot(metric: &MetricCurves) -> Result<String, RecordError> {
    let label = format!("{}: {} over the results of the history", metric.scenario, metric.column);
    picture(&label, SIZE, |area, overlay| draw(metric, area, overlay))
}

fn draw(metric: &MetricCurves, area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let values = || metric.curves.iter().flat_map(|curve| curve.values.iter().copied().flatten());
    let drawn: Vec<Vec<(f64, f64)>> = metric.curves.iter().map(|curve| points(curve, shows_changes(metric))).collect();
    // Differences within the default tolerance of a comparison look flat.
    let largest = values().map(f64::abs).fold(0.0, f64::max);
    let y = linear(drawn.iter().flatten().map(|point| point.1), 5, 4.0 * (1e-9 + 1e-6 * largest));
    let results = metric.results.len();
    let stride = results.div_ceil(MAX_LABELS).max(1);
    // Counted from the newest, which is always labelled.
    let ticks: Vec<f64> =
        (0..results).filter(|at| (results - 1 - at).is_multiple_of(stride)).map(|at| at as f64).collect();
    let x = Axis { from: -0.5, to: results as f64 - 0.5, ticks, fine: Vec::new(), logarithmic: false };
    let title = |at: f64| metric.results.get(at as usize).map(|(title, _)| shortened(title)).unwrap_or_default();
    let x_side = Side { axis: &x, title: "results, the newest last", label: &title };
    let y_side = Side { axis: &y, title: "", label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space { left: 76, ..Space::SINGLE })?;
    for (index, (curve, points)) in metric.curves.iter().zip(drawn).enumerate() {
        let line = LineSeries::new(points.iter().copied(), palette::rgb(palette::curve(index)).stroke_width(6));
        chart.draw_series(line).map_err(|e| text_of(&e))?;
        for (at, height) in points {
            let value = curve.values[at as usize].unwrap_or(f64::NAN);
            let (name, date) = &metric.results[at as usize];
            let run = if curve.run.is_empty() { String::new() } else { format!("{}: ", curve.run) };
            let date = if date == name { String::new() } else { format!(", {date}") };
            let title = format!("{run}{value:?} in {name}{date}");
            overlay.mark(mark(index), chart.backend_coord(&(at, height)), palette::curve(index), true, &title);
        }
    }
    Ok(())
}

/// True if the picture shows changes instead of values.
pub(super) fn shows_changes(metric: &MetricCurves) -> bool {
    metric.curves.len() > 1
}

/// Position of the result, and value or change since the first one, of each value of a curve.
fn points(curve: &Curve, as_changes: bool) -> Vec<(f64, f64)> {
    let known = || curve.values.iter().enumerate().filter_map(|(at, value)| Some((at as f64, (*value)?)));
    let zero = known().next().filter(|_| as_changes).map_or(0.0, |(_, first)| first);
    known().map(|(at, value)| (at, value - zero)).collect()
}

/// The mark of a curve.
pub(super) fn mark(index: usize) -> Mark {
    Mark::ALL[index % Mark::ALL.len()]
}

/// The value of a curve in the newest result that has one, for the legend.
pub(super) fn newest(values: &[Option<f64>]) -> String {
    values.iter().rev().copied().flatten().next().map_or_else(|| "–".to_owned(), short)
}

/// A label that fits under the axis: long ones, such as commits, by their beginning.
fn shortened(title: &str) -> String {
    // A date without its time.
    let title = title.strip_suffix(" UTC").and_then(|date| date.split_once(' ')).map_or(title, |(day, _)| day);
    match title.chars().count() {
        ..=LABEL_LENGTH => title.to_owned(),
        _ => title.chars().take(LABEL_LENGTH - 1).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_fit_under_the_axis() {
        assert_eq!(shortened("v1.2"), "v1.2");
        assert_eq!(shortened("2026-11-21 19:05 UTC"), "2026-11-21");
        assert_eq!(shortened("3e15917797f34c1eb4281a"), "3e15917797f34c1…");
    }
}
