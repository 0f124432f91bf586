//! Colours. Those of curves are distinguishable with common colour blindness, and in grey.

use crate::contact::methods::registry::MethodDescriptor;
use plotters::style::RGBColor;

/// A colour as SVG writes it. The style sheet matches this text and replaces the colour on dark
/// pages.
pub(super) type Colour = &'static str;

/// Background.
pub(super) const PAPER: Colour = "#FFFFFF";
/// Text.
pub(super) const INK: Colour = "#1F2933";
/// Secondary text.
pub(super) const FAINT: Colour = "#52606D";
/// Axes.
pub(super) const AXIS: Colour = "#8895A4";
/// Lines at labelled values.
pub(super) const GRID: Colour = "#DDE2E8";
/// Lines between.
pub(super) const FINE: Colour = "#EEF1F4";

/// Colours of curves.
const CURVES: [Colour; 6] = ["#0B62A4", "#D55E00", "#00795A", "#9C3587", "#8A6A00", "#5B6770"];

/// A sole that sticks.
pub(super) const STATIC: Colour = "#0B62A4";
/// A sole that slides.
pub(super) const DYNAMIC: Colour = "#D55E00";
/// A state of another name.
pub(super) const OTHER: Colour = "#5B6770";

/// All colours, for the test of the style sheet.
#[cfg(test)]
pub(super) const ALL: [&[Colour]; 2] = [&[PAPER, INK, FAINT, AXIS, GRID, FINE], &CURVES];

/// The colour of a contact method: the same in every picture.
pub(super) fn method(name: &str) -> Colour {
    MethodDescriptor::named(name).map_or(CURVES[CURVES.len() - 1], |method| method.colour)
}

/// The colour of the curve at an index, in a cycle.
pub(super) fn curve(index: usize) -> Colour {
    CURVES[index % CURVES.len()]
}

/// The colour as plotters takes it.
pub(super) fn rgb(colour: Colour) -> RGBColor {
    let part = |at: usize| colour.get(at..at + 2).and_then(|hex| u8::from_str_radix(hex, 16).ok()).unwrap_or(0);
    RGBColor(part(1), part(3), part(5))
}
