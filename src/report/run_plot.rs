//! Draws a run over time: height of the base, force of each sole and other contact, and a bar for each with its
//! contact states.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear};
use crate::report::canvas::{Area, DrawError, Overlay, SCALE, picture, swatch};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette::{self, Colour};
use crate::report::run_history::{History, SoleHistory, Stay};
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Sizes of the picture and its parts, pixels.
const WIDTH: u32 = 720;
const CURVES: u32 = 134;
const TIME: u32 = 36;
const STATES: u32 = 26;
const LEFT: u32 = 76;
/// Width of a letter of a name, and the number of letters of the longest name that is not shortened.
const LETTER: u32 = 7;
const LONGEST: usize = 24;

/// Greatest number of soles drawn.
const MAX_SOLES: usize = 12;

/// Draws a run.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn run_over_time(name: &str, history: &History) -> Result<String, RecordError> {
    let parts = parts(history);
    let height = parts.iter().map(|p| p.height).sum::<u32>() + TIME;
    picture(&format!("{name} over time"), (WIDTH, height), |area, overlay| draw(history, &parts, area, overlay))
}

/// Colour and name of each sole's force.
pub(super) fn legend(history: &History) -> Vec<(String, String)> {
    let soles = history.soles.iter().take(MAX_SOLES).enumerate();
    let name = |sole: &SoleHistory| format!("{}{}", sole.name, if sole.is_magnitude { ", magnitude" } else { "" });
    soles.map(|(i, sole)| (name(sole), swatch(None, palette::curve(i)))).collect()
}

/// A colour, and values over time, s.
type Line = (Colour, Vec<(f64, f64)>);

/// Curves of one quantity, or the states.
struct Part {
    height: u32,
    title: &'static str,
    /// None for the states.
    curves: Option<Vec<Line>>,
    /// Least span of the axis, in its unit.
    least: f64,
}

fn parts(history: &History) -> Vec<Part> {
    let mut parts = Vec::new();
    if !history.height.is_empty() {
        let curve = vec![(palette::INK, history.height.clone())];
        parts.push(Part { height: CURVES, title: "base height, m", curves: Some(curve), least: 1e-3 });
    }
    let soles: Vec<&SoleHistory> = history.soles.iter().take(MAX_SOLES).collect();
    if !soles.is_empty() {
        let curves = soles.iter().enumerate().map(|(i, s)| (palette::curve(i), s.force.clone())).collect();
        let title = if soles.iter().any(|sole| sole.is_magnitude) { "force, N" } else { "normal force, N" };
        parts.push(Part { height: CURVES, title, curves: Some(curves), least: 1e-3 });
        let height = STATES * soles.len() as u32 + 16;
        parts.push(Part { height, title: "", curves: None, least: 0.0 });
    }
    parts
}

fn draw(history: &History, parts: &[Part], area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let names = history.soles.iter().take(MAX_SOLES).map(|sole| sole.name.chars().count().min(LONGEST));
    let margin = LEFT.max(30 + LETTER * names.max().unwrap_or(0) as u32);
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let (from, to) = history.span;
    let time = linear([from, to].into_iter(), 8, 1e-6);
    // The time axis ends with the run.
    let (from, to) = if from < to { (from, to) } else { (time.from, time.to) };
    let ticks: Vec<f64> = time.ticks.iter().copied().filter(|t| (from..=to).contains(t)).collect();
    let time = Axis { from, to, ticks, ..time };
    let mut rest = area.clone();
    for (i, part) in parts.iter().enumerate() {
        let last = i + 1 == parts.len();
        let below = if last { TIME } else { 0 };
        let (own, next) = rest.split_vertically((part.height + below) * SCALE);
        rest = next;
        let values = || part.curves.iter().flatten().flat_map(|(_, points)| points).map(|p| p.1);
        let y = match part.curves {
            Some(_) => linear(values(), 4, part.least),
            None => Axis { from: 0.0, to: 1.0, ticks: Vec::new(), fine: Vec::new(), logarithmic: false },
        };
        let x_side =
            Side { axis: &time, title: if last { "simulated time, s" } else { "" }, label: &|v| time.label(v) };
        let y_side = Side { axis: &y, title: part.title, label: &|v| y.label(v) };
        let mut chart = chart(&own, &x_side, &y_side, Space::stacked(below, margin))?;
        let curves = part.curves.as_deref().unwrap_or_default();
        for (i, (colour, points)) in curves.iter().enumerate() {
            // The first curve is the widest, so that it shows below the others.
            let width = 5 + 4 * (curves.len() - 1 - i).min(2) as u32;
            let line = LineSeries::new(points.iter().copied(), palette::rgb(colour).stroke_width(width));
            chart.draw_series(line).map_err(|e| text_of(&e))?;
        }
        if part.curves.is_none() {
            let soles: Vec<&SoleHistory> = history.soles.iter().take(MAX_SOLES).collect();
            for (i, sole) in soles.iter().enumerate() {
                let rows = soles.len() as f64;
                let (top, bottom) = (1.0 - i as f64 / rows, 1.0 - (i + 1) as f64 / rows);
                let at = |t: f64, share: f64| {
                    let (foot, head) = (bottom + 0.08 / rows, top - 0.12 / rows);
                    chart.backend_coord(&(t, foot + share * (head - foot)))
                };
                let left = chart.backend_coord(&(from, (top + bottom) / 2.0));
                overlay.text((left.0 - 24, left.1), palette::INK, true, &brief(&sole.name));
                sole.stays.iter().for_each(|stay| band(overlay, &sole.name, stay, &at));
            }
        }
    }
    Ok(())
}

/// A bar while a sole is in contact: high for a face, medium for an edge, low for a vertex.
fn band(overlay: &mut Overlay, sole: &str, stay: &Stay, at: &impl Fn(f64, f64) -> (i32, i32)) {
    let share = match stay.state.split('-').next() {
        Some("free") => return,
        Some("vertex") => 0.34,
        Some("edge") => 0.67,
        _ => 1.0,
    };
    let colour = match stay.state.rsplit('-').next() {
        Some("static") => palette::STATIC,
        Some("dynamic") => palette::DYNAMIC,
        _ => palette::OTHER,
    };
    let title = format!("{sole}: {}, {:.4} s to {:.4} s", stay.state, stay.from, stay.to);
    overlay.bar(at(stay.from, share), at(stay.to, 0.0), colour, &title);
}

/// A name shortened to the margin of the picture.
fn brief(name: &str) -> String {
    if name.chars().count() <= LONGEST {
        name.to_owned()
    } else {
        name.chars().take(LONGEST - 1).chain(['…']).collect()
    }
}
