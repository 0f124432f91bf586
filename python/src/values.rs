//! Converts Python values to TOML, and JSON to Python values.

use std::path::PathBuf;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString, PyTuple};
use stiction::batch::Overrides;
use toml::Value;

/// Deepest nesting of values; a value that contains itself has no end.
const DEEPEST: usize = 64;

/// Refuses values that are nested too deeply. `path` has a dot or bracket for each level.
fn check_depth(path: &str) -> PyResult<()> {
    if path.bytes().filter(|b| matches!(b, b'.' | b'[')).count() > DEEPEST {
        let start: String = path.chars().take(40).collect();
        return Err(PyValueError::new_err(format!("{start}...: nested more than {DEEPEST} levels")));
    }
    Ok(())
}

/// The TOML value of a Python value: texts, paths, flags, numbers, dictionaries and sequences, also those
/// of NumPy. `path` names its position in messages.
pub fn to_toml(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    check_depth(path)?;
    if let Ok(text) = value.cast::<PyString>() {
        Ok(Value::String(text.extract()?))
    } else if value.is_instance_of::<PyBool>() {
        Ok(Value::Boolean(value.extract()?))
    } else if value.is_instance_of::<PyInt>() {
        let range = |_| PyValueError::new_err(format!("{path}: {value} is not an integer of 64 bits"));
        value.extract().map(Value::Integer).map_err(range)
    } else if value.is_instance_of::<PyFloat>() {
        Ok(Value::Float(value.extract()?))
    } else if let Ok(table) = value.cast::<PyMapping>() {
        to_table(table, path).map(Value::Table)
    } else if value.hasattr("tolist")? {
        // Arrays and scalars of NumPy. Some scalars, such as long doubles, convert to themselves.
        let converted = value.call_method0("tolist")?;
        match converted.get_type().is(value.get_type()) {
            true => Ok(Value::Float(value.call_method0("__float__")?.extract()?)),
            false => to_toml(&converted, path),
        }
    } else if value.hasattr("__fspath__")? {
        let file: PathBuf = value.extract()?;
        Ok(Value::String(file.to_string_lossy().into_owned()))
    } else if let Ok(list) = value.cast::<PySequence>() {
        let entries = list.try_iter()?.enumerate().map(|(i, entry)| to_toml(&entry?, &format!("{path}[{i}]")));
        entries.collect::<PyResult<_>>().map(Value::Array)
    } else {
        let found = value.get_type().name()?;
        let expected = "expected a text, path, number, flag, dictionary or sequence";
        Err(PyTypeError::new_err(format!("{path}: found a value of type {found}, {expected}")))
    }
}

/// The TOML table of a dictionary; values that are `None` are left out.
fn to_table(table: &Bound<'_, PyMapping>, path: &str) -> PyResult<toml::Table> {
    let mut out = toml::Table::new();
    for (key, value) in entries(table, path)? {
        let inner = joined(path, &key);
        out.insert(key, to_toml(&value, &inner)?);
    }
    Ok(out)
}

/// Keys and values of a dictionary in its order, without those that are `None`.
fn entries<'py>(table: &Bound<'py, PyMapping>, path: &str) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let mut all = Vec::new();
    for item in table.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let Ok(key) = key.extract::<String>() else {
            let name = if path.is_empty() { "the scenario" } else { path };
            return Err(PyTypeError::new_err(format!("{name}: found the key {key}, expected a text")));
        };
        if !value.is_none() {
            all.push((key, value));
        }
    }
    Ok(all)
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// The TOML text of a dictionary. Tables and their keys keep their order, on which that of the runs of a
/// sweep depends.
pub fn to_text(table: &Bound<'_, PyMapping>) -> PyResult<String> {
    let (mut values, mut tables) = (String::new(), String::new());
    for (key, value) in entries(table, "")? {
        let name = written_key(&key);
        match value.cast::<PyMapping>() {
            Ok(inner) => {
                tables += &format!("\n[{name}]\n");
                for (entry, value) in entries(inner, &key)? {
                    let path = joined(&key, &entry);
                    tables += &format!("{} = {}\n", written_key(&entry), inline(&value, &path)?);
                }
            }
            Err(_) => values += &format!("{name} = {}\n", inline(&value, &key)?),
        }
    }
    Ok(values + &tables)
}

/// A value in one line.
fn inline(value: &Bound<'_, PyAny>, path: &str) -> PyResult<String> {
    check_depth(path)?;
    if let Ok(table) = value.cast::<PyMapping>() {
        let entry = |(key, value): (String, Bound<'_, PyAny>)| {
            Ok(format!("{} = {}", written_key(&key), inline(&value, &joined(path, &key))?))
        };
        let all: Vec<String> = entries(table, path)?.into_iter().map(entry).collect::<PyResult<_>>()?;
        return Ok(if all.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", all.join(", ")) });
    }
    let is_list = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
    if is_list {
        let entries = value.try_iter()?.enumerate().map(|(i, entry)| inline(&entry?, &format!("{path}[{i}]")));
        return Ok(format!("[{}]", entries.collect::<PyResult<Vec<_>>>()?.join(", ")));
    }
    to_toml(value, path).map(|value| value.to_string())
}

/// A key, in quotes where it must be.
fn written_key(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !key.is_empty() && key.chars().all(is_bare) {
        true => key.to_owned(),
        // The escapes of JSON are those of TOML, which would write a line break as it is.
        false => serde_json::to_string(key).unwrap_or_default(),
    }
}

/// Overrides by dotted key.
pub fn overrides(pairs: &[(String, Bound<'_, PyAny>)]) -> PyResult<Overrides> {
    pairs.iter().map(|(key, value)| Ok((key.clone(), to_toml(value, key)?))).collect()
}

/// The Python value of a JSON text.
pub fn of_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// An entry of a dictionary of options; none if it is missing or `None`.
pub fn option<'py, T>(options: &Bound<'py, PyDict>, name: &str) -> PyResult<Option<T>>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    match options.get_item(name)? {
        Some(value) if !value.is_none() => value.extract().map(Some),
        _ => Ok(None),
    }
}
