//! Rows of `runs.jsonl`. A run with several lines counts once, with its last line; an incomplete
//! last line is skipped.

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::{BufRead, BufReader};

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::compare::columns::{Columns, RunDigest, digest};
use crate::compare::file_spans::{FileSpans, Span};
use crate::compare::row_source::{Opened, ResultsErrorCause, Rows};
use crate::files::checksum::{self, Layout};

/// An open list.
pub(super) struct JsonRows {
    file: FileSpans,
    rows: Vec<Line>,
}

/// A line of the file.
struct Line {
    span: Span,
    /// Its number, from 1.
    number: usize,
}

impl JsonRows {
    /// Opens a list, checks its lines and finds the last one of each run.
    pub fn open(file: File) -> Opened {
        let mut reader = BufReader::new(&file);
        let (mut at, mut line, mut number) = (0, Vec::new(), 0);
        let mut columns = Columns::default();
        let (mut rows, mut runs): (Vec<Line>, Vec<RunDigest>) = Default::default();
        let mut known: HashMap<RunDigest, usize> = HashMap::new();
        loop {
            line.clear();
            let read = reader.read_until(b'\n', &mut line)?;
            if read == 0 {
                break;
            }
            let offset = at;
            at += read as u64;
            number += 1;
            let is_whole = line.pop_if(|byte| *byte == b'\n').is_some();
            let mut own = [String::new(), String::new()];
            match parse(&line, Fields::Identity { columns: &mut columns, own: &mut own }) {
                Ok(()) => {}
                Err(_) if !is_whole => break,
                Err(error) => return Err(ResultsErrorCause::Line { line: number, error }),
            }
            if !checksum::is_intact(&line, Layout::Line) {
                return Err(ResultsErrorCause::Damaged { line: number });
            }
            let run = digest(own.iter().map(String::as_str));
            let line = Line { span: Span { offset, length: line.len() }, number };
            match known.get(&run) {
                Some(&earlier) => rows[earlier] = line,
                None => {
                    known.insert(run, rows.len());
                    runs.push(run);
                    rows.push(line);
                }
            }
        }
        Ok((columns, runs, Box::new(JsonRows { file: FileSpans::new(file)?, rows })))
    }
}

impl Rows for JsonRows {
    fn read(&mut self, position: usize, columns: &Columns, cells: &mut [String]) -> Result<(), ResultsErrorCause> {
        let Line { span, number } = self.rows[position];
        let line = self.file.read(span)?;
        parse(line, Fields::All { columns, cells }).map_err(|error| ResultsErrorCause::Line { line: number, error })
    }
}

fn parse(line: &[u8], fields: Fields<'_>) -> serde_json::Result<()> {
    let mut json = serde_json::Deserializer::from_slice(line);
    json.deserialize_map(fields)?;
    json.end()
}

/// What is read of an object.
enum Fields<'a> {
    /// Scenario and key, and the names of columns.
    Identity { columns: &'a mut Columns, own: &'a mut [String; 2] },
    /// All cells.
    All { columns: &'a Columns, cells: &'a mut [String] },
}

impl<'de> Visitor<'de> for Fields<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<M: MapAccess<'de>>(mut self, mut map: M) -> Result<(), M::Error> {
        while let Some(target) = map.next_key_seed(Name(&mut self))? {
            match (&mut self, target) {
                (Fields::Identity { own, .. }, Target::Identity(which)) => {
                    map.next_value_seed(Cell(&mut own[which]))?
                }
                (Fields::All { cells, .. }, Target::Cell(position)) => {
                    map.next_value_seed(Cell(&mut cells[position]))?
                }
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }
}

/// Where the value of a member belongs.
enum Target {
    Nowhere,
    Identity(usize),
    Cell(usize),
}

/// The name of a member.
struct Name<'s, 'a>(&'s mut Fields<'a>);

impl<'de> DeserializeSeed<'de> for Name<'_, '_> {
    type Value = Target;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Target, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Name<'_, '_> {
    type Value = Target;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E>(self, name: &str) -> Result<Target, E> {
        Ok(match self.0 {
            _ if name == checksum::MEMBER => Target::Nowhere,
            Fields::Identity { columns, .. } => {
                if columns.position(name).is_none() {
                    columns.add(name.to_owned());
                }
                ["scenario", "key"].iter().position(|own| *own == name).map_or(Target::Nowhere, Target::Identity)
            }
            Fields::All { columns, .. } => columns.position(name).map_or(Target::Nowhere, Target::Cell),
        })
    }
}

/// A value as text. Lists, objects and `null` are empty cells.
struct Cell<'a>(&'a mut String);

impl<'de> DeserializeSeed<'de> for Cell<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Cell<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_str<E>(self, text: &str) -> Result<(), E> {
        self.0.replace_range(.., text);
        Ok(())
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        *self.0 = value.to_string();
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        *self.0 = value.to_string();
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        *self.0 = value.to_string();
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        *self.0 = serde_json::Number::from_f64(value).map_or_else(|| value.to_string(), |number| number.to_string());
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.0.clear();
        Ok(())
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<(), S::Error> {
        self.0.clear();
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(())
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<(), M::Error> {
        self.0.clear();
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(())
    }
}
