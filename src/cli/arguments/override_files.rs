//! Values of `--set-from`: files of keys and values, such as `fitted.toml` of `runner fit`.

use std::path::Path;

use crate::batch::Severity;
use crate::input;
use crate::scenario::{Diagnostic, segment};
use crate::text::Source;

/// Reads the values of a file by dotted key. Keys in quotes are dotted paths, as in `--set`; keys of
/// tables are parts of one.
///
/// # Errors
/// The file cannot be read or is not TOML.
pub fn read(path: &Path) -> Result<Vec<(String, toml::Value)>, Box<Diagnostic>> {
    let name = path.display().to_string();
    let text = input::read_text(path, input::MOST_TEXT)
        .map_err(|error| Box::new(Diagnostic::whole_file(&name, format!("cannot read the file: {error}"))))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let range = error.span().unwrap_or(0..0);
        let source = Source::new(path, &text);
        Box::new(Diagnostic::in_source(Severity::Error, &source, range, error.message(), None))
    })?;
    let mut values = Vec::new();
    for (key, value) in table {
        collect(key, value, &mut values);
    }
    Ok(values)
}

fn collect(path: String, value: toml::Value, values: &mut Vec<(String, toml::Value)>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                collect(format!("{path}.{}", segment(&key)), value, values);
            }
        }
        value => values.push((path, value)),
    }
}
