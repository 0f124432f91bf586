//! Draws a claim: the share that it is about with its bounds over the runs, and the threshold.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear};
use crate::report::canvas::{Area, DrawError, Overlay, picture};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette::{self, Colour};
use crate::results::claims::{ClaimVerdict, TracePoint};
use plotters::prelude::LineSeries;
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
    let unit = if claim.paired { "pairs of runs" } else { "runs" };
    let x_side = Side { axis: &x, title: &format!("{unit}, in the order of the plan"), label: &|v| x.label(v) };
    let y_side = Side { axis: &y, title: "share", label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space::SINGLE)?;
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
