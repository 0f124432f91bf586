//! A picture: the drawing of plotters, overlaid with elements that its SVG lacks: marks with
//! titles.
//!
//! Pictures are drawn in quarters of pixels, since plotters rounds to whole units. Colours are
//! those of a light page, see [`crate::report::palette`]; the page's style sheet replaces them on a
//! dark one.

use crate::files::RecordError;
use crate::report::palette::{self, Colour};
use minijinja::HtmlEscape;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, IntoDrawingArea, SVGBackend};
use plotters::style::{FontFamily, FontStyle, IntoFont, TextStyle};
use std::fmt::Write;

/// Units per pixel.
pub(super) const SCALE: u32 = 4;

/// Drawing area of plotters.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Reason of a failed drawing.
pub(super) type DrawError = String;

/// A point, in units.
pub(super) type PixelPoint = (i32, i32);

/// Draws a picture of `size` pixels; `label` describes it for screen readers.
///
/// # Errors
/// It cannot be drawn.
pub(super) fn picture(
    label: &str,
    size: (u32, u32),
    draw: impl FnOnce(&Area, &mut Overlay) -> Result<(), DrawError>,
) -> Result<String, RecordError> {
    let failure = |reason: String| RecordError::Plot { what: label.to_owned(), reason };
    let mut svg = String::new();
    let mut overlay = Overlay::default();
    {
        let area = SVGBackend::with_string(&mut svg, (size.0 * SCALE, size.1 * SCALE)).into_drawing_area();
        draw(&area, &mut overlay).map_err(failure)?;
        area.present().map_err(|e| failure(e.to_string()))?;
    }
    let body = svg.trim_end().strip_suffix("</svg>").and_then(|s| s.split_once('>'));
    let (_, body) = body.ok_or_else(|| failure("the drawing is not an SVG".into()))?;
    let (width, height) = (size.0 * SCALE, size.1 * SCALE);
    let (label, overlay) = (HtmlEscape(label), overlay.svg);
    Ok(format!(
        "<svg class=\"plot\" role=\"img\" aria-label=\"{label}\" width=\"{}\" height=\"{}\" \
         viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\">{body}{overlay}</svg>",
        size.0, size.1
    ))
}

/// Text of a size in pixels.
pub(super) fn text(size: u32, colour: Colour) -> TextStyle<'static> {
    // plotters divides by this when it writes.
    let size = f64::from(size * SCALE) * 1.24;
    (FontFamily::SansSerif, size, FontStyle::Normal).into_font().color(&palette::rgb(colour))
}

/// Elements above what plotters drew, and those of legends.
#[derive(Default)]
pub(super) struct Overlay {
    svg: String,
}

/// The shape of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Square,
    Triangle,
    Diamond,
    Down,
    Cross,
}

impl Mark {
    /// In the order of curves.
    pub const ALL: [Mark; 6] = [Mark::Circle, Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Down, Mark::Cross];

    /// Its outline about a point, about 4 pixels from the middle.
    fn path(self, (x, y): PixelPoint) -> String {
        match self {
            Mark::Circle => format!("M{} {y}a16 16 0 1 0 32 0a16 16 0 1 0 -32 0z", x - 16),
            Mark::Square => format!("M{} {}h28v28h-28z", x - 14, y - 14),
            Mark::Triangle => format!("M{x} {}l18 30h-36z", y - 20),
            Mark::Diamond => format!("M{x} {}l18 20l-18 20l-18 -20z", y - 20),
            Mark::Down => format!("M{x} {}l-18 -30h36z", y + 20),
            Mark::Cross => {
                let arms = "l8 -8l10 10l10 -10l8 8l-10 10l10 10l-8 8l-10 -10l-10 10l-8 -8l10 -10z";
                format!("M{} {}{arms}", x - 18, y - 10)
            }
        }
    }
}

impl Overlay {
    /// A mark, full or hollow, with a title.
    pub fn mark(&mut self, mark: Mark, at: PixelPoint, colour: Colour, full: bool, title: &str) {
        let fill = if full { colour } else { palette::PAPER };
        let path = mark.path(at);
        // A String takes every write, here and below.
        let _ = writeln!(
            self.svg,
            "<path d=\"{path}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"6\"><title>{}</title></path>",
            HtmlEscape(title)
        );
    }

    /// A dashed line with a title.
    pub fn dashes(&mut self, points: &[PixelPoint], colour: Colour, title: &str) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
        let _ = writeln!(
            self.svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"4\" stroke-dasharray=\"16 12\">\
             <title>{}</title></polyline>",
            points.join(" "),
            HtmlEscape(title)
        );
    }

    /// A full rectangle with a title, which may be empty.
    pub fn bar(&mut self, from: PixelPoint, to: PixelPoint, colour: Colour, title: &str) {
        let (width, height) = ((to.0 - from.0).max(1), (to.1 - from.1).max(1));
        let (x, y) = from;
        let _ = write!(self.svg, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{colour}\"");
        let _ = match title {
            "" => writeln!(self.svg, "/>"),
            title => writeln!(self.svg, "><title>{}</title></rect>", HtmlEscape(title)),
        };
    }

    /// Text that begins (ends, with `end`) at a point and is vertically centred on it.
    pub fn text(&mut self, at: PixelPoint, colour: Colour, end: bool, text: &str) {
        let anchor = if end { "end" } else { "start" };
        let size = 12 * SCALE;
        let _ = writeln!(
            self.svg,
            "<text x=\"{}\" y=\"{}\" dy=\"0.36em\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" \
             font-size=\"{size}\" fill=\"{colour}\">{}</text>",
            at.0,
            at.1,
            HtmlEscape(text)
        );
    }
}

/// The line and mark of a curve, for a legend.
pub(super) fn swatch(mark: Option<Mark>, colour: Colour) -> String {
    let mut overlay = Overlay::default();
    if let Some(mark) = mark {
        overlay.mark(mark, (56, 24), colour, true, "");
    }
    let marks = overlay.svg.replace("<title></title>", "");
    format!(
        "<svg class=\"swatch\" aria-hidden=\"true\" width=\"28\" height=\"12\" viewBox=\"0 0 112 48\" \
         xmlns=\"http://www.w3.org/2000/svg\"><line x1=\"0\" y1=\"24\" x2=\"112\" y2=\"24\" stroke=\"{colour}\" \
         stroke-width=\"8\"/>{marks}</svg>"
    )
}
