//! Draws a claim: the share that it is about with its bounds over the runs, and the threshold.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear};
use crate::report::canvas::{Area, DrawError, Overlay, SCALE, picture, text};
use crate::report::palette::{self, Colour};
use crate::results::claims::{ClaimVerdict, TracePoint};
use plotters::prelude::{ChartBuilder, LineSeries};
use plotters::style::Color;

/// Width and height, pixels.
const SIZE: (u32, u32) = (560, 280);

/// Part of the units at the beginning that is not drawn where there are many: its bounds are wide.
const LEFT_OUT: usize = 20;

/// A curve of the picture.
type Curve = (Colour, u32, fn(&TracePoint) -> f64);

/// Draws a claim with a history.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn claim_plot(claim: &ClaimVerdict) -> Result<String, RecordError> {
    let label = format!("{}: share and bounds over the runs", claim.name());
    picture(&label, SIZE, |area, overlay| draw(claim, area, overlay))
}

fn draw(claim: &ClaimVerdict, area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let points: Vec<&TracePoint> = claim.trace.iter().filter(|p| p.units >= claim.used / LEFT_OUT).collect();
    let values = points.iter().flat_map(|p| [p.share, p.lower, p.upper]).chain([claim.threshold]);
    let y = linear(values, 6, 0.01);
    let x = linear(points.iter().map(|p| p.units as f64), 8, 1.0);
    let units = || points.iter().map(|p| p.units);
    let (from, to) = match (units().min(), units().max()) {
        (Some(first), Some(last)) if first < last => (first as f64, last as f64),
        _ => (x.from, x.to),
    };
    let ticks = x.ticks.iter().copied().filter(|t| (from..=to).contains(t)).collect();
    let x = Axis { from, to, ticks, ..x };
    let mut chart = ChartBuilder::on(area)
        .margin(6 * SCALE)
        .margin_right(16 * SCALE)
        .x_label_area_size(38 * SCALE)
        .y_label_area_size(60 * SCALE)
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(|e| text_of(&e))?;
    let grid = palette::rgb(palette::GRID).stroke_width(4);
    let unit = if claim.paired { "pairs of runs" } else { "runs" };
    chart
        .configure_mesh()
        .bold_line_style(grid)
        .light_line_style(grid)
        .axis_style(palette::rgb(palette::AXIS).stroke_width(4))
        .label_style(text(12, palette::FAINT))
        .axis_desc_style(text(13, palette::INK))
        .x_desc(format!("{unit}, in the order of the plan"))
        .y_desc("share")
        .x_label_formatter(&|v| x.label(*v))
        .y_label_formatter(&|v| y.label(*v))
        .draw()
        .map_err(|e| text_of(&e))?;
    let curves: [Curve; 3] =
        [(palette::curve(0), 5, |p| p.lower), (palette::curve(0), 5, |p| p.upper), (palette::INK, 7, |p| p.share)];
    for (colour, width, value) in curves {
        let line = points.iter().map(|p| (p.units as f64, value(p)));
        chart.draw_series(LineSeries::new(line, palette::rgb(colour).stroke_width(width))).map_err(|e| text_of(&e))?;
    }
    let at = |x: f64, y: f64| chart.backend_coord(&(x, y));
    let side = if claim.at_least { "at least" } else { "at most" };
    let title = format!("threshold {}; the claim is {side} {}", claim.threshold, claim.limit);
    overlay.dashes(&[at(from, claim.threshold), at(to, claim.threshold)], palette::curve(1), &title);
    Ok(())
}
