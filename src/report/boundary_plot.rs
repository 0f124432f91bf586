//! Draws a search: the values that were run for each combination of swept values, in the colour of
//! their results, and the boundaries.

use crate::files::RecordError;
use crate::report::axis::{Axis, linear, logarithmic};
use crate::report::canvas::{Area, DrawError, Mark, Overlay, picture};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette;
use crate::results::searches::{Probe, SearchResult};

/// Width and height, pixels.
const SIZE: (u32, u32) = (720, 320);

/// Half the length of a boundary's line, as a fraction of the distance of two combinations.
const HALF_LINE: f64 = 0.35;

/// Draws the boundaries of a scenario over one key.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn boundary_plot(searches: &[SearchResult]) -> Result<String, RecordError> {
    let SearchResult { subject, keys, .. } = &searches[0];
    let label = format!("values of {} that were run, and where {subject} begins or ceases to hold", keys[0]);
    picture(&label, SIZE, |area, overlay| draw(searches, area, overlay))
}

fn draw(searches: &[SearchResult], area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let SearchResult { subject, keys, .. } = &searches[0];
    let key = &keys[0];
    let values = searches.iter().flat_map(|search| &search.probes).map(|probe| probe.at[0]);
    let y = axis(&searches[0], 0, values, 6);
    let count = searches.len() as f64;
    let x = linear([0.0, count - 1.0].into_iter(), 10, 1.0);
    let ticks = x.ticks.iter().copied().filter(|tick| tick.fract() == 0.0).collect();
    let x = Axis { from: -0.5, to: count - 0.5, ticks, ..x };
    let x_side =
        Side { axis: &x, title: "combination of swept values, in the order of the plan", label: &|v| v.to_string() };
    let y_side = Side { axis: &y, title: key, label: &|v| y.label(v) };
    let chart = chart(area, &x_side, &y_side, Space::SINGLE)?;
    let at = |x: f64, y: f64| chart.backend_coord(&(x, y));
    for (column, search) in searches.iter().enumerate() {
        let column = column as f64;
        for probe in &search.probes {
            let (mark, colour, result) = shown(probe, subject);
            let title = format!("{} {key} = {}: {result}", search.label, probe.at[0]);
            overlay.mark(mark, at(column, probe.at[0]), colour, probe.holds == Some(true), title.trim_start());
        }
        if let Some(interval) = &search.interval {
            let value = 0.5 * (interval.lower + interval.upper);
            let ends = [at(column - HALF_LINE, value), at(column + HALF_LINE, value)];
            let title = format!("{} {}", search.label, search.found());
            overlay.dashes(&ends, palette::INK, title.trim_start());
        }
    }
    Ok(())
}

/// The axis of a searched key around its values, with about `labels` labels.
pub(super) fn axis(search: &SearchResult, key: usize, values: impl Iterator<Item = f64>, labels: u32) -> Axis {
    if search.logarithmic.get(key) == Some(&true) { logarithmic(values) } else { linear(values, labels, 1e-9) }
}

/// Mark, colour and description of a result.
pub(super) fn shown(probe: &Probe, condition: &str) -> (Mark, palette::Colour, String) {
    match probe.holds {
        Some(true) => (Mark::Circle, palette::curve(1), condition.to_owned()),
        Some(false) => (Mark::Circle, palette::curve(0), format!("not {condition}")),
        None => (Mark::Cross, palette::curve(5), probe.outcome.clone()),
    }
}
