//! Lays out tables of text in columns that fit the width of a terminal.

use std::borrow::Cow;

use super::excerpt::shorten_middle;

/// Width, in characters, to which columns of text are shrunk at most.
const MIN_TEXT_WIDTH: usize = 8;

/// Characters kept of the beginning and the end of a long cell: padding has a limit of 65 535.
const CELL_ENDS: (usize, usize) = (200, 100);

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alignment {
    /// For text, which is clipped if the table is too wide.
    Left,
    /// For numbers, of which the header alone is clipped.
    Right,
}

/// A header and lines of cells.
#[derive(Clone, Debug)]
pub struct TextTable {
    alignments: Vec<Alignment>,
    lines: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with this header.
    pub fn new<T: Into<String>>(header: impl IntoIterator<Item = (T, Alignment)>) -> Self {
        let (names, alignments) = header.into_iter().map(|(name, alignment)| (name.into(), alignment)).unzip();
        TextTable { alignments, lines: vec![Vec::into_iter(names).map(limited).collect()] }
    }

    /// Adds a line. Missing cells are empty, further ones are dropped.
    pub fn push(&mut self, mut cells: Vec<String>) {
        cells.resize(self.alignments.len(), String::new());
        self.lines.push(cells.into_iter().map(limited).collect());
    }

    /// Lines below the header.
    pub fn rows(&self) -> usize {
        self.lines.len() - 1
    }

    /// Width of the longest line when no cell is clipped, in characters.
    pub fn natural_width(&self) -> usize {
        total(&self.widths(0))
    }

    /// The text, its columns two spaces apart. Where it is wider than `width`, the widest columns
    /// of text are clipped, then headers of numbers. Numbers are never clipped, so that a table of
    /// many numbers may stay too wide.
    pub fn render(&self, width: usize) -> String {
        let (mut widths, numbers) = (self.widths(0), self.widths(1));
        let mut excess = total(&widths).saturating_sub(width);
        while excess > 0 {
            let least = |c: usize| if self.alignments[c] == Alignment::Left { MIN_TEXT_WIDTH } else { numbers[c] };
            let of = |alignment: Alignment| (0..widths.len()).filter(move |&c| self.alignments[c] == alignment);
            let widest = |alignment| of(alignment).filter(|&c| widths[c] > least(c)).max_by_key(|&c| widths[c]);
            let Some(column) = widest(Alignment::Left).or_else(|| widest(Alignment::Right)) else { break };
            widths[column] -= 1;
            excess -= 1;
        }
        let mut out = String::new();
        for line in &self.lines {
            let cells = line.iter().zip(&widths).zip(&self.alignments).map(|((cell, &w), alignment)| match alignment {
                Alignment::Left => format!("{:<w$}", clip(cell, w)),
                Alignment::Right => format!("{:>w$}", clip(cell, w)),
            });
            out += cells.collect::<Vec<_>>().join("  ").trim_end();
            out.push('\n');
        }
        out
    }

    /// The widest cell of each column, from a line on.
    fn widths(&self, from: usize) -> Vec<usize> {
        let widest = |c: usize| self.lines[from..].iter().map(|line| line[c].chars().count()).max();
        (0..self.alignments.len()).map(|c| widest(c).unwrap_or(0)).collect()
    }
}

/// A cell of bounded length: a longer one loses its middle.
pub fn limited(cell: String) -> String {
    match shorten_middle(&cell, CELL_ENDS) {
        Cow::Borrowed(_) => cell,
        Cow::Owned(short) => short,
    }
}

fn total(widths: &[usize]) -> usize {
    widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1)
}

/// At most this many characters; an ellipsis replaces the end of a longer text.
pub fn clip(text: &str, max_width: usize) -> String {
    match text.chars().count() <= max_width {
        true => text.to_owned(),
        false => text.chars().take(max_width.saturating_sub(1)).chain(['…']).collect(),
    }
}

/// A number with this many significant digits: as a decimal fraction, or with an exponent where
/// that would be long.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let rounded = format!("{:.*e}", digits.saturating_sub(1), x);
    let exponent: i32 = rounded.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    match exponent {
        -4..6 => format!("{x:.*}", (digits as i32 - 1 - exponent).max(0) as usize),
        _ => rounded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> TextTable {
        let mut table =
            TextTable::new([("name", Alignment::Left), ("long header", Alignment::Right), ("note", Alignment::Left)]);
        table.push(vec!["short".into(), "0.125".into(), "a note of thirty characters...".into()]);
        table.push(vec!["a longer name".into(), "12".into()]);
        table
    }

    #[test]
    fn columns_are_aligned_and_lines_end_without_spaces() {
        let wide = table().render(200);
        assert_eq!(
            wide,
            "name           long header  note\n\
             short                0.125  a note of thirty characters...\n\
             a longer name           12\n"
        );
        assert_eq!((table().natural_width(), table().rows()), (58, 2));
    }

    #[test]
    fn cells_of_any_length_are_shown_by_their_ends() {
        let mut table = TextTable::new([("x".repeat(70_000), Alignment::Left), ("n".into(), Alignment::Right)]);
        table.push(vec![format!("begin{}end", "é".repeat(70_000)), "1".repeat(70_000)]);
        let text = table.render(usize::MAX);
        assert!(text.contains("begin") && text.contains("end") && text.contains('…'));
        assert!(text.lines().all(|line| line.chars().count() <= 610), "{}", text.len());
    }

    #[test]
    fn text_is_clipped_first_then_headers_and_never_a_number() {
        for width in 25..60 {
            let text = table().render(width);
            assert!(text.lines().all(|line| line.chars().count() <= width), "{width}\n{text}");
            assert!(text.contains("0.125") && text.contains("12"), "{width}\n{text}");
        }
        assert!(table().render(40).contains("long header") && table().render(40).contains("a note o"));
        assert!(table().render(25).contains("long…  "), "{}", table().render(25));
        assert!(table().render(3).contains("0.125"), "numbers stay whole");
    }

    #[test]
    fn numbers_have_the_digits_that_matter() {
        let cases =
            [(0.0, "0"), (0.108_34, "0.108"), (-7.0, "-7.00"), (60.0, "60.0"), (1234.5, "1234"), (9.999, "10.0")];
        for (x, text) in cases {
            assert_eq!(significant(x, 3), text);
        }
        assert_eq!(significant(1.0 / 3.0, 6), "0.333333");
        assert_eq!(significant(2.5e-17, 3), "2.50e-17");
        assert_eq!(significant(1.25e7, 3), "1.25e7");
        assert_eq!((significant(f64::NAN, 3), significant(f64::INFINITY, 3)), ("NaN".into(), "inf".into()));
    }
}
