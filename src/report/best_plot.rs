//! Draws a search for the best value of a metric: the values in the order in which their runs were
//! chosen, and the best so far.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear, logarithmic};
use crate::report::canvas::{Area, DrawError, Mark, Overlay, picture};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette;
use crate::results::searches::{Probe, SearchKind, SearchResult};
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Width and height, pixels.
const SIZE: (u32, u32) = (640, 320);

/// Ratio of positive values above which their axis is logarithmic.
const WIDE: f64 = 100.0;

/// Draws a search for the least or greatest value of a metric.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn best_plot(search: &SearchResult) -> Result<String, RecordError> {
    let label = format!("{} over the runs, and the best value so far", search.subject);
    picture(&label, SIZE, |area, overlay| draw(search, area, overlay))
}

fn draw(search: &SearchResult, area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let values: Vec<(f64, f64, &Probe)> =
        search.probes.iter().enumerate().filter_map(|(i, probe)| Some((i as f64 + 1.0, probe.value?, probe))).collect();
    let better = if search.search == SearchKind::Minimum { f64::min } else { f64::max };
    let best: Vec<(f64, f64)> = values
        .iter()
        .scan(None, |best: &mut Option<f64>, (run, value, _)| {
            *best = Some(best.map_or(*value, |best| better(best, *value)));
            Some((*run, (*best)?))
        })
        .collect();
    let sizes = || values.iter().map(|(_, value, _)| *value);
    let (least, greatest) = sizes().fold((f64::INFINITY, 0.0_f64), |(l, g), value| (l.min(value), g.max(value)));
    // Distances that become small.
    let is_wide = least > 0.0 && greatest > WIDE * least;
    let y = if is_wide { logarithmic(sizes()) } else { linear(sizes(), 6, 1e-18) };
    let count = search.probes.len().max(2) as f64;
    let x = Axis { from: 0.0, to: count + 1.0, ..linear([1.0, count].into_iter(), 8, 1.0) };
    let x_side = Side { axis: &x, title: "runs, in the order in which they were chosen", label: &|v| x.label(v) };
    let y_side = Side { axis: &y, title: &search.subject, label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space::SINGLE)?;
    let style = palette::rgb(palette::INK).stroke_width(6);
    chart.draw_series(LineSeries::new(best, style)).map_err(|e| text_of(&e))?;
    for (run, value, probe) in values {
        let at: Vec<String> = search.keys.iter().zip(&probe.at).map(|(key, x)| format!("{key} = {x}")).collect();
        let title = format!("{}: {value}", at.join(", "));
        overlay.mark(Mark::Circle, chart.backend_coord(&(run, value)), palette::curve(0), false, &title);
    }
    Ok(())
}
