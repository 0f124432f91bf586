//! Columns of text for gnuplot and programs that read tables like it does: separator, numbers, header, comments and blocks
//! as wanted.

use crate::export::columns::TIME;
use crate::export::select;
use crate::export::{DataTable, ExportError, NumberFormat, Values};

/// How a table becomes text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextFormat {
    /// Between two cells.
    pub separator: String,
    /// How numbers are written.
    pub numbers: NumberFormat,
    /// What stands above the columns.
    pub header: Header,
    /// What a line begins with that is no data.
    pub comment: String,
    /// What stands where there is no number.
    pub missing: String,
    /// Unit of the time.
    pub time: TimeUnit,
    /// Column at whose changes a new block begins: two empty lines, which gnuplot counts as `index`.
    pub blocks: Option<String>,
}

/// What stands above the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Header {
    /// The names as a row of their own, of every block: gnuplot's `columnheader`.
    Plain,
    /// The names behind a comment sign.
    Comment,
    /// Nothing.
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
            header: Header::Plain,
            comment: "#".into(),
            missing: "NaN".into(),
            time: TimeUnit::Seconds,
            blocks: None,
        }
    }
}

impl TimeUnit {
    /// Name of the column of the time.
    fn name(self) -> &'static str {
        match self {
            Self::Seconds => TIME,
            Self::Milliseconds => "time_ms",
            Self::Minutes => "time_min",
        }
    }

    fn of(self, seconds: f64) -> f64 {
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
                // What begins a block is told in a comment.
                text.push_str(&format!("{} index {block}: {name} = ", self.comment));
                self.cell(values, row, &mut text);
                text.push('\n');
                // gnuplot's `columnheader` is the first row of every block.
                self.header(table, &mut text);
            }
            for (at, (_, values)) in table.columns().iter().enumerate() {
                match values {
                    Values::Real(v) if at == 0 => self.number(v[row].map(|t| self.time.of(t)), &mut text),
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
        let name = |(name, _): &(String, Values)| self.word(if name == TIME { self.time.name() } else { name });
        let names = table.columns().iter().map(name).collect::<Vec<_>>().join(&self.separator);
        match self.header {
            Header::Comment => text.push_str(&format!("{} {names}\n", self.comment)),
            Header::Plain => text.push_str(&format!("{names}\n")),
            Header::None => {}
        }
    }

    fn cell(&self, values: &Values, row: usize, line: &mut String) {
        match values {
            Values::Real(v) => self.number(v[row], line),
            Values::Text(v) => line.push_str(&self.word(&v[row])),
            Values::Flag(v) => line.push(if v[row] { '1' } else { '0' }),
        }
    }

    fn number(&self, value: Option<f64>, line: &mut String) {
        match value {
            Some(x) => self.numbers.write(x, line),
            None => line.push_str(&self.missing),
        }
    }

    /// A word on one line, in quotes if it could be taken for several cells or for a comment.
    fn word(&self, word: &str) -> String {
        let one_line = word.replace(['\n', '\r'], " ");
        let splits = |part: &str| !part.is_empty() && one_line.contains(part);
        let risky = one_line.is_empty() || one_line.contains([' ', '\t', '"']);
        if risky || splits(&self.separator) || splits(&self.comment) {
            return format!("\"{}\"", one_line.replace('"', "'"));
        }
        one_line
    }
}

fn column<'a>(table: &'a DataTable, name: &str) -> Result<&'a Values, ExportError> {
    table.column(name).ok_or_else(|| {
        let names: Vec<&str> = table.columns().iter().map(|(name, _)| name.as_str()).collect();
        ExportError::UnknownColumn { name: name.to_owned(), help: select::help(name, &names) }
    })
}

impl Values {
    /// Is the value of a row another than that of the row before.
    fn changes(&self, row: usize) -> bool {
        match self {
            Values::Real(v) => v[row] != v[row - 1],
            Values::Text(v) => v[row] != v[row - 1],
            Values::Flag(v) => v[row] != v[row - 1],
        }
    }
}
