//! Draws a search over two keys: the values that were run, in the colour of their results, and the
//! boundary.

use crate::files::RecordError;
use crate::report::boundary_plot::{axis, shown};
use crate::report::canvas::{Area, DrawError, Overlay, picture};
use crate::report::chart::{Side, Space, chart};
use crate::report::palette;
use crate::results::searches::{LinePoint, SearchResult};
use plotters::prelude::LineSeries;
use plotters::style::Color;

/// Width and height, pixels.
const SIZE: (u32, u32) = (640, 480);

/// Draws a boundary over two keys.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn line_plot(search: &SearchResult) -> Result<String, RecordError> {
    let SearchResult { subject, keys, .. } = search;
    let label = format!("values of {} that were run, and where {subject} begins or ceases to hold", keys.join(" and "));
    picture(&label, SIZE, |area, overlay| draw(search, area, overlay))
}

fn draw(search: &SearchResult, area: &Area, overlay: &mut Overlay) -> Result<(), DrawError> {
    let text_of = |e: &dyn std::fmt::Display| e.to_string();
    let [x, y] = [0, 1].map(|i| axis(search, i, search.probes.iter().map(|probe| probe.at[i]), 8));
    let x_side = Side { axis: &x, title: &search.keys[0], label: &|v| x.label(v) };
    let y_side = Side { axis: &y, title: &search.keys[1], label: &|v| y.label(v) };
    let mut chart = chart(area, &x_side, &y_side, Space::SINGLE)?;
    for line in &search.lines {
        let points = line.iter().map(LinePoint::middle).map(|[x, y]| (x, y));
        let style = palette::rgb(palette::INK).stroke_width(6);
        chart.draw_series(LineSeries::new(points, style)).map_err(|e| text_of(&e))?;
    }
    for probe in &search.probes {
        let (mark, colour, result) = shown(probe, &search.subject);
        let title = format!("{} = {}, {} = {}: {result}", search.keys[0], probe.at[0], search.keys[1], probe.at[1]);
        let at = chart.backend_coord(&(probe.at[0], probe.at[1]));
        overlay.mark(mark, at, colour, probe.holds == Some(true), &title);
    }
    Ok(())
}
