//! Draws a fitted signal over time: measured points and the fitted curve, below them the residuals over the noise.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear};
use crate::report::canvas::{Area, DrawError, Mark, Overlay, SCALE, picture, swatch};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette::{self, Colour};
use plotters::element::Circle;
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Sizes of the picture and its parts, pixels.
const WIDTH: u32 = 720;
const SIGNAL: u32 = 200;
const RESIDUALS: u32 = 110;
const TIME: u32 = 36;
const LEFT: u32 = 84;

/// Greatest number of points drawn; of more, every n-th.
const MAX_POINTS: usize = 1500;

/// Colours of measured points and of the fitted curve.
const MEASURED: Colour = palette::FAINT;
const FITTED: usize = 1;

/// A fitted signal.
#[derive(Clone, Debug, Default)]
pub struct FittedSignal {
    /// Title of the picture, such as the names of data and column.
    pub title: String,
    /// Label of the axis, with its unit.
    pub label: String,
    /// Measured values: s, unit.
    pub measured: Vec<(f64, f64)>,
    /// Simulated values with the fitted parameters: s, unit.
    pub fitted: Vec<(f64, f64)>,
    /// Simulated minus measured over the noise: s, 1.
    pub residuals: Vec<(f64, f64)>,
}

/// Names and swatches of the curves.
pub(super) fn legend() -> Vec<(String, String)> {
    vec![
        ("measured".to_owned(), swatch(Some(Mark::Circle), MEASURED)),
        ("fitted".to_owned(), swatch(None, palette::curve(FITTED))),
    ]
}

/// Draws a signal.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn fitted_over_time(signal: &FittedSignal) -> Result<String, RecordError> {
    let label = format!("{}: measured, fitted and residuals over time", signal.title);
    picture(&label, (WIDTH, SIGNAL + RESIDUALS + TIME), |area, overlay| draw(signal, area, overlay))
}

fn draw(signal: &FittedSignal, area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let times = signal.measured.iter().map(|point| point.0);
    let (from, to) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let axis = linear([from, to].into_iter().filter(|t| t.is_finite()), 8, 1e-6);
    let (from, to) = if from < to { (from, to) } else { (axis.from, axis.to) };
    let ticks = axis.ticks.iter().copied().filter(|t| (from..=to).contains(t)).collect();
    let time = Axis { from, to, ticks, ..axis };
    let (upper, lower) = area.split_vertically(SIGNAL * SCALE);
    let values = signal.measured.iter().chain(&signal.fitted).map(|point| point.1);
    let part = Part { label: &signal.label, values: linear(values, 4, 1e-9), below: 0, time: &time };
    draw_part(&upper, &part, &signal.measured, Some(&signal.fitted), overlay)?;
    let residuals = signal.residuals.iter().map(|point| point.1);
    let values = linear(residuals.chain([-2.0, 2.0]), 3, 1.0);
    let part = Part { label: "residual / sigma", values, below: TIME, time: &time };
    draw_part(&lower, &part, &signal.residuals, None, overlay)
}

/// The axes of a part of the picture.
struct Part<'a> {
    label: &'a str,
    values: Axis,
    /// Height of the labels below, pixels.
    below: u32,
    time: &'a Axis,
}

fn draw_part(
    area: &Area,
    part: &Part,
    points: &[(f64, f64)],
    curve: Option<&[(f64, f64)]>,
    overlay: &mut Overlay,
) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let (time, y) = (part.time, &part.values);
    let x_side =
        Side { axis: time, title: if part.below > 0 { "simulated time, s" } else { "" }, label: &|v| time.label(v) };
    let y_side = Side { axis: y, title: part.label, label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space::stacked(part.below, LEFT))?;
    match curve {
        Some(curve) => {
            let line = LineSeries::new(thinned(curve), palette::rgb(palette::curve(FITTED)).stroke_width(6));
            chart.draw_series(line).map_err(|e| text_of(&e))?;
        }
        None => {
            let zero = [chart.backend_coord(&(time.from, 0.0)), chart.backend_coord(&(time.to, 0.0))];
            overlay.dashes(&zero, palette::curve(FITTED), "no residual");
        }
    }
    let style = palette::rgb(MEASURED).filled();
    let dots = thinned(points).map(|point| Circle::new(point, 8, style));
    chart.draw_series(dots).map_err(|e| text_of(&e))?;
    Ok(())
}

fn thinned(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().copied().step_by(points.len().div_ceil(MAX_POINTS).max(1))
}
