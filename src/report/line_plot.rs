//! Draws a search over two keys: the values that were run, in the colour of their results, and the
//! boundary.

use crate::files::RecordError;
use crate::report::boundary_plot::{axis, shown};
use crate::report::canvas::{Area, DrawError, Overlay, SCALE, picture, text};
use crate::report::palette;
use crate::results::searches::{LinePoint, SearchResult};
use plotters::prelude::{ChartBuilder, LineSeries};
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
    let mut chart = ChartBuilder::on(area)
        .margin(6 * SCALE)
        .margin_right(16 * SCALE)
        .x_label_area_size(38 * SCALE)
        .y_label_area_size(60 * SCALE)
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(|e| text_of(&e))?;
    let grid = palette::rgb(palette::GRID).stroke_width(4);
    chart
        .configure_mesh()
        .bold_line_style(grid)
        .light_line_style(grid)
        .axis_style(palette::rgb(palette::AXIS).stroke_width(4))
        .label_style(text(12, palette::FAINT))
        .axis_desc_style(text(13, palette::INK))
        .x_desc(search.keys[0].clone())
        .y_desc(search.keys[1].clone())
        .x_label_formatter(&|v| x.label(*v))
        .y_label_formatter(&|v| y.label(*v))
        .draw()
        .map_err(|e| text_of(&e))?;
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
