//! Draws the work-precision picture: error over cost, both logarithmic, one curve per method.

use crate::files::RecordError;
use crate::math;
use crate::metrics::unit;
use crate::report::axis::{self, logarithmic};
use crate::report::canvas::{Area, DrawError, Mark, Overlay, PixelPoint, picture, swatch};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette::{self, Colour};
use crate::results::is_truth;
use crate::results::pareto::{Curve, Group, Work, front_as_shown};
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Width and height, pixels.
const SIZE: (u32, u32) = (560, 380);

/// Styles of the curves of a group, by their names.
pub(super) struct CurveStyles {
    names: Vec<(String, String)>,
}

/// Style of a curve.
#[derive(Clone, Copy)]
pub(super) struct CurveStyle {
    pub colour: Colour,
    pub mark: Mark,
}

impl CurveStyles {
    /// Styles for the curves of a group.
    pub fn of(group: &Group) -> Self {
        let mut names: Vec<(String, String)> = Vec::new();
        for curve in &group.curves {
            let own = (curve.name(), curve.method.clone());
            if !names.contains(&own) {
                names.push(own);
            }
        }
        Self { names }
    }

    fn style(&self, name: &str) -> CurveStyle {
        let index = self.names.iter().position(|(n, _)| n == name).unwrap_or(0);
        let method = self.names.get(index).map_or("", |(_, method)| method);
        CurveStyle { colour: palette::method(method), mark: Mark::ALL[index % Mark::ALL.len()] }
    }

    /// Name and swatch of each curve.
    pub fn legend(&self) -> Vec<(String, String)> {
        let entry = |(name, _): &(String, String)| {
            let style = self.style(name);
            (name.clone(), swatch(Some(style.mark), style.colour))
        };
        self.names.iter().map(entry).collect()
    }
}

/// A run in the picture.
struct Spot {
    row: usize,
    cost: f64,
    error: f64,
    on_front: bool,
}

/// Draws one error of a group; `None` if no run of it has a point.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn work_precision(
    works: &[Work],
    group: &Group,
    column: &str,
    styles: &CurveStyles,
) -> Result<Option<String>, RecordError> {
    let spots = spots(works, group, column);
    if spots.is_empty() {
        return Ok(None);
    }
    let label = format!("{column} over cost, {}", group.name());
    picture(&label, SIZE, |area, overlay| draw(works, group, column, styles, &spots, area, overlay)).map(Some)
}

fn spots(works: &[Work], group: &Group, column: &str) -> Vec<Spot> {
    let point = |row: usize| works[row].point(column).ok().map(|(cost, error)| (row, cost, error));
    let points: Vec<_> = group.rows().filter_map(point).collect();
    let on = front_as_shown(&points.iter().map(|&(_, cost, error)| (cost, error)).collect::<Vec<_>>());
    points.into_iter().zip(on).map(|((row, cost, error), on_front)| Spot { row, cost, error, on_front }).collect()
}

fn draw(
    works: &[Work],
    group: &Group,
    column: &str,
    styles: &CurveStyles,
    spots: &[Spot],
    area: &Area,
    overlay: &mut Overlay,
) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let nonzero = || spots.iter().map(|s| s.error).filter(|e| *e > 0.0);
    // If all errors are 0, any decade serves.
    let least = nonzero().fold(f64::INFINITY, f64::min);
    let least = axis::clamped(if least.is_finite() { least } else { 1e-15 });
    // Errors of 0 are drawn a whole decade below the least.
    let floor = math::powf(10.0, (math::log10(least) - 1.0).floor());
    let zeros = spots.iter().any(|s| s.error == 0.0);
    let mut y = logarithmic(nonzero().chain(zeros.then_some(floor)));
    if zeros {
        // The axis has no scale below this line.
        y.ticks.retain(|v| *v > 1.01 * floor);
        y.fine.retain(|v| *v > 1.01 * floor);
    }
    let x = logarithmic(spots.iter().map(|s| s.cost));
    let unit = unit(column);
    let y_title = if unit.is_empty() { "error".to_owned() } else { format!("error, {unit}") };
    let x_side = Side { axis: &x, title: "cost, processor seconds per simulated second", label: &|v| x.label(v) };
    let y_side = Side { axis: &y, title: &y_title, label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space::SINGLE)?;
    let point = |s: &Spot| {
        let error = if s.error > 0.0 { axis::clamped(s.error) } else { floor };
        (axis::clamped(s.cost), error)
    };
    let find = |row: &usize| spots.iter().find(|s| s.row == *row);
    for curve in &group.curves {
        let style = styles.style(&curve.name());
        // The logarithmic axis has no point for an error of 0, so no line leads there.
        let own: Vec<&Spot> = curve.rows.iter().filter_map(find).collect();
        for part in own.split(|s| s.error == 0.0).filter(|part| part.len() > 1) {
            let line = LineSeries::new(part.iter().map(|s| point(s)), palette::rgb(style.colour).stroke_width(6));
            chart.draw_series(line).map_err(|e| text_of(&e))?;
        }
    }
    let at = |s: &Spot| chart.backend_coord(&point(s));
    let (left, right) = (chart.backend_coord(&(x.from, y.from)).0, chart.backend_coord(&(x.to, y.from)).0);
    if zeros {
        let height = chart.backend_coord(&(x.from, floor)).1;
        overlay.dashes(&[(left, height), (right, height)], palette::AXIS, "no error at all");
        overlay.text((left - 24, height), palette::FAINT, true, "0");
    }
    overlay.dashes(&stairs(spots, at, right), palette::FAINT, "Pareto front");
    for curve in &group.curves {
        let style = styles.style(&curve.name());
        for spot in curve.rows.iter().filter_map(find) {
            let title = title(&works[spot.row], curve, column, unit, spot);
            overlay.mark(style.mark, at(spot), style.colour, spot.on_front, &title);
        }
    }
    Ok(())
}

/// The Pareto front as a step curve: least error for at most each cost.
fn stairs(spots: &[Spot], at: impl Fn(&Spot) -> PixelPoint, right: i32) -> Vec<PixelPoint> {
    let mut front: Vec<&Spot> = spots.iter().filter(|s| s.on_front).collect();
    front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut points: Vec<PixelPoint> = Vec::new();
    for spot in front {
        let (x, y) = at(spot);
        if let Some(&(_, before)) = points.last() {
            points.push((x, before));
        }
        points.push((x, y));
    }
    if let Some(&(_, last)) = points.last() {
        points.push((right, last));
    }
    points
}

/// Title of a mark.
fn title(work: &Work, curve: &Curve, column: &str, unit: &str, spot: &Spot) -> String {
    let row = work.row;
    let mut lines = vec![format!("{} {}", curve.method, curve.integrator)];
    let own = |name: &str| ["contact.method", "integrator.method"].contains(&name) || is_truth(name);
    lines.extend(row.parameters.iter().filter(|(name, _)| !own(name)).map(|(name, value)| format!("{name} = {value}")));
    lines.push(format!("{column}: {:.3e} {unit}", spot.error).trim_end().to_owned());
    lines.push(format!("cost: {:.3e} s per s, {:.1} x real time", spot.cost, work.real_time_factor));
    lines.push(format!("{}{}", row.key, if spot.on_front { ", on the Pareto front" } else { "" }));
    lines.join("\n")
}
