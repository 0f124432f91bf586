//! A chart with what all charts have in common: axes, grid, labels and titles.

use crate::report::axis::Axis;
use crate::report::canvas::{Area, DrawError, SCALE, text};
use crate::report::palette;
use plotters::coord::cartesian::Cartesian2d;
use plotters::prelude::{ChartBuilder, ChartContext, SVGBackend};
use plotters::style::Color;

/// A chart in which curves are drawn.
pub(super) type Chart<'area, 'svg> = ChartContext<'area, SVGBackend<'svg>, Cartesian2d<Axis, Axis>>;

/// An axis with its title, which may be empty, and the text of each label.
pub(super) struct Side<'a> {
    pub axis: &'a Axis,
    pub title: &'a str,
    pub label: &'a dyn Fn(f64) -> String,
}

/// Space around the plotted values, pixels.
#[derive(Clone, Copy)]
pub(super) struct Space {
    /// Margins at the left and below, above, and at the right.
    pub margins: [u32; 3],
    /// Height of labels and title of the horizontal axis.
    pub below: u32,
    /// Width of those of the vertical axis.
    pub left: u32,
}

impl Space {
    /// Of a picture with one chart.
    pub const SINGLE: Space = Space { margins: [6, 6, 16], below: 38, left: 60 };

    /// Of one of several charts above each other.
    pub fn stacked(below: u32, left: u32) -> Self {
        Space { margins: [0, 12, 14], below, left }
    }
}

/// Draws the axes and the grid of a chart.
///
/// # Errors
/// They cannot be drawn.
pub(super) fn chart<'area, 'svg>(
    area: &'area Area<'svg>,
    x: &Side,
    y: &Side,
    space: Space,
) -> Result<Chart<'area, 'svg>, DrawError> {
    let Space { margins: [margin, top, right], below, left } = space;
    let mut chart = ChartBuilder::on(area)
        .margin(margin * SCALE)
        .margin_top(top * SCALE)
        .margin_right(right * SCALE)
        .x_label_area_size(below * SCALE)
        .y_label_area_size(left * SCALE)
        .build_cartesian_2d(x.axis.clone(), y.axis.clone())
        .map_err(|e| e.to_string())?;
    chart
        .configure_mesh()
        .bold_line_style(palette::rgb(palette::GRID).stroke_width(4))
        .light_line_style(palette::rgb(palette::FINE).stroke_width(4))
        .axis_style(palette::rgb(palette::AXIS).stroke_width(4))
        .label_style(text(12, palette::FAINT))
        .axis_desc_style(text(13, palette::INK))
        .x_desc(x.title)
        .y_desc(y.title)
        .x_label_formatter(&|v| (x.label)(*v))
        .y_label_formatter(&|v| (y.label)(*v))
        .draw()
        .map_err(|e| e.to_string())?;
    Ok(chart)
}
