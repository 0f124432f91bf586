//! Rows of a table of comma-separated values (RFC 4180): cells with commas, quotes or line breaks
//! are quoted, quotes in them doubled.

use std::fs::File;
use std::io::{BufRead, BufReader};

use crate::compare::columns::{Columns, RunDigest, digest};
use crate::compare::file_spans::{FileSpans, Span};
use crate::compare::row_source::{Opened, ResultsErrorCause, Rows};

/// An open table.
pub(super) struct CsvRows {
    file: FileSpans,
    rows: Vec<Span>,
}

impl CsvRows {
    /// Opens a table and finds its rows.
    pub fn open(file: File) -> Opened {
        let mut reader = BufReader::new(&file);
        let (mut at, mut record) = (0, Vec::new());
        let (mut rows, mut runs): (Vec<Span>, Vec<RunDigest>) = Default::default();
        let mut columns: Option<Columns> = None;
        loop {
            record.clear();
            let length = read_record(&mut reader, &mut record)?;
            if length == 0 {
                break;
            }
            let span = Span { offset: at, length: record.len() };
            at += length as u64;
            let Some(columns) = &columns else {
                let text = std::str::from_utf8(&record).map_err(std::io::Error::other)?;
                columns = Some(Columns::new(cells(text.trim_start_matches('\u{feff}'))));
                continue;
            };
            if record.is_empty() && columns.len() > 1 {
                continue;
            }
            let text = std::str::from_utf8(&record).map_err(std::io::Error::other)?;
            let place = ["scenario", "key"].map(|name| columns.position(name));
            let mut own = [String::new(), String::new()];
            let mut found = 0;
            for (position, cell) in cells(text).enumerate() {
                found += 1;
                for (own, place) in own.iter_mut().zip(place) {
                    if place == Some(position) {
                        *own = cell.clone();
                    }
                }
            }
            if found != columns.len() {
                return Err(ResultsErrorCause::Cells { row: rows.len() + 1, found, expected: columns.len() });
            }
            runs.push(digest(own.iter().map(String::as_str)));
            rows.push(span);
        }
        Ok((columns.unwrap_or_default(), runs, Box::new(CsvRows { file: FileSpans::new(file)?, rows })))
    }
}

impl Rows for CsvRows {
    fn read(&mut self, position: usize, columns: &Columns, row: &mut [String]) -> Result<(), ResultsErrorCause> {
        let text = std::str::from_utf8(self.file.read(self.rows[position])?).map_err(std::io::Error::other)?;
        let mut found = 0;
        for cell in cells(text) {
            if let Some(to) = row.get_mut(found) {
                *to = cell;
            }
            found += 1;
        }
        let expected = columns.len();
        if found == expected { Ok(()) } else { Err(ResultsErrorCause::Cells { row: position + 1, found, expected }) }
    }
}

/// Reads a record without its line break; returns the number of bytes read, 0 at the end.
fn read_record(reader: &mut impl BufRead, record: &mut Vec<u8>) -> std::io::Result<usize> {
    let mut length = 0;
    loop {
        let begin = record.len();
        let read = reader.read_until(b'\n', record)?;
        length += read;
        // A line break inside quotes belongs to the cell; doubled quotes count twice.
        let is_open = record.iter().filter(|byte| **byte == b'"').count() % 2 == 1;
        if read > 0 && is_open && record[begin..].ends_with(b"\n") {
            continue;
        }
        for end in [b'\n', b'\r'] {
            if record.last() == Some(&end) {
                record.pop();
            }
        }
        return Ok(length);
    }
}

/// The cells of a record.
fn cells(record: &str) -> impl Iterator<Item = String> {
    let mut rest = Some(record);
    std::iter::from_fn(move || {
        let text = rest?;
        let Some(quoted) = text.strip_prefix('"') else {
            let (cell, after) = text.split_once(',').map_or((text, None), |(cell, after)| (cell, Some(after)));
            rest = after;
            return Some(cell.to_owned());
        };
        let (mut cell, mut left) = (String::new(), quoted);
        loop {
            let (part, after) = left.split_once('"').unwrap_or((left, ""));
            cell += part;
            match after.strip_prefix('"') {
                Some(more) => {
                    cell.push('"');
                    left = more;
                }
                None => {
                    rest = after.strip_prefix(',');
                    return Some(cell);
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_unquoted() {
        let of = |record: &str| cells(record).collect::<Vec<_>>();
        assert_eq!(of("a,,b"), ["a", "", "b"]);
        assert_eq!(of(""), [""]);
        assert_eq!(of(r#""a,b","say ""x""","",c"#), ["a,b", "say \"x\"", "", "c"]);
        assert_eq!(of("a,"), ["a", ""]);
        assert_eq!(of("\"open"), ["open"]);
    }

    #[test]
    fn records_may_span_lines() {
        let mut text: &[u8] = b"a,b\r\n\"1\n2\",\"x\"\"\n\"\n\nlast";
        let mut found = Vec::new();
        loop {
            let mut record = Vec::new();
            if read_record(&mut text, &mut record).unwrap() == 0 {
                break;
            }
            found.push(String::from_utf8(record).unwrap());
        }
        assert_eq!(found, ["a,b", "\"1\n2\",\"x\"\"\n\"", "", "last"]);
    }
}
