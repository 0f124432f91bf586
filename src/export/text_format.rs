//! Writes a table as columns of text, for gnuplot and programs with a similar input format.

use crate::export::column_choice;
use crate::export::data_table::{DataTable, Values};
use crate::export::export_error::ExportError;
use crate::export::log_columns::TIME;
use crate::export::number_format::NumberFormat;

/// Layout of a table as text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextFormat {
    /// Separator of cells.
    pub separator: String,
    /// Format of numbers.
    pub numbers: NumberFormat,
    /// Style of the header.
    pub header: HeaderStyle,
    /// Start of a comment line.
    pub comment: String,
    /// Text of an absent number.
    pub missing: String,
    /// Unit of the time.
    pub time: TimeUnit,
    /// Column whose changes begin a new block, after two empty lines; gnuplot numbers the blocks by
    /// `index`.
    pub blocks: Option<String>,
}

/// Style of the names above the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderStyle {
    /// The names are the first row of every block: gnuplot's `columnheader`.
    Plain,
    /// The names follow a comment sign.
    Comment,
    /// No names.
    None,
}

/// A unit of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds.
    Seconds,
    /// Milliseconds.
    Milliseconds,
    /// Minutes.
    Minutes,
}

impl Default for TextFormat {
    fn default() -> Self {
        Self {
            separator: " ".into(),
            numbers: NumberFormat::Exact,
            header: HeaderStyle::Plain,
            comment: "#".into(),
            missing: "NaN".into(),
            time: TimeUnit::Seconds,
            blocks: None,
        }
    }
}

impl TimeUnit {
    /// Name of the time column.
    fn name(self) -> &'static str {
        match self {
            Self::Seconds => TIME,
            Self::Milliseconds => "time_ms",
            Self::Minutes => "time_min",
        }
    }

    fn of_seconds(self, seconds: f64) -> f64 {
        match self {
            Self::Seconds => seconds,
            Self::Milliseconds => seconds * 1e3,
            Self::Minutes => seconds / 60.0,
        }
    }
}

impl TextFormat {
    pub(super) fn write(&self, table: &DataTable, out: &mut Vec<u8>) -> Result<(), ExportError> {
        let by = self.blocks.as_deref().map(|name| column(table, name).map(|values| (name, values))).transpose()?;
        let mut text = String::new();
        let mut block = 0;
        if by.is_none() || table.rows() == 0 {
            self.header(table, &mut text);
        }
        for row in 0..table.rows() {
            if let Some((name, values)) = by
                && (row == 0 || values.changes(row))
            {
                if row > 0 {
                    block += 1;
                    text.push_str("\n\n");
                }
                // A comment names the value that starts the block.
                text.push_str(&format!("{} index {block}: {name} = ", self.comment));
                self.cell(values, row, &mut text);
                text.push('\n');
                // gnuplot's `columnheader` is the first row of every block.
                self.header(table, &mut text);
            }
            for (at, (_, values)) in table.columns().iter().enumerate() {
                match values {
                    Values::Real(v) if at == 0 => self.number(v[row].map(|t| self.time.of_seconds(t)), &mut text),
                    _ => {
                        text.push_str(&self.separator);
                        self.cell(values, row, &mut text);
                    }
                }
            }
            text.push('\n');
        }
        out.extend_from_slice(text.as_bytes());
        Ok(())
    }

    fn header(&self, table: &DataTable, text: &mut String) {
        let name = |(name, _): &(String, Values)| self.quoted(if name == TIME { self.time.name() } else { name });
        let names = table.columns().iter().map(name).collect::<Vec<_>>().join(&self.separator);
        match self.header {
            HeaderStyle::Comment => text.push_str(&format!("{} {names}\n", self.comment)),
            HeaderStyle::Plain => text.push_str(&format!("{names}\n")),
            HeaderStyle::None => {}
        }
    }

    fn cell(&self, values: &Values, row: usize, line: &mut String) {
        match values {
            Values::Real(v) => self.number(v[row], line),
            Values::Text(v) => line.push_str(&self.quoted(&v[row])),
            Values::Flag(v) => line.push(if v[row] { '1' } else { '0' }),
        }
    }

    fn number(&self, value: Option<f64>, line: &mut String) {
        match value {
            Some(x) => self.numbers.write(x, line),
            None => line.push_str(&self.missing),
        }
    }

    /// A text on one line, quoted if it could be read as several cells or as a comment.
    fn quoted(&self, text: &str) -> String {
        let one_line = text.replace(['\n', '\r'], " ");
        let splits = |part: &str| !part.is_empty() && one_line.contains(part);
        let ambiguous = one_line.is_empty() || one_line.contains([' ', '\t', '"']);
        if ambiguous || splits(&self.separator) || splits(&self.comment) {
            return format!("\"{}\"", one_line.replace('"', "'"));
        }
        one_line
    }
}

fn column<'a>(table: &'a DataTable, name: &str) -> Result<&'a Values, ExportError> {
    table.column(name).ok_or_else(|| {
        let names: Vec<&str> = table.columns().iter().map(|(name, _)| name.as_str()).collect();
        ExportError::UnknownColumn { name: name.to_owned(), help: column_choice::help(name, &names) }
    })
}

impl Values {
    /// True if the value of a row differs from that of the row before.
    fn changes(&self, row: usize) -> bool {
        match self {
            Values::Real(v) => v[row] != v[row - 1],
            Values::Text(v) => v[row] != v[row - 1],
            Values::Flag(v) => v[row] != v[row - 1],
        }
    }
}
