//! The scenario that a session is.

use std::path::{Component, Path, PathBuf};

use toml::{Table, Value};

use crate::console::ConsoleError;
use crate::console::words::segments;
use crate::files::{Made, RecordError, SESSION, write_named};
use crate::scenario::{self, Diagnostics, Run};
use std::io::Write;

/// Parts of a file that are of a batch, not of one run, and rules that would end a session.
const NOT_OF_A_SESSION: [&str; 4] = ["sweep", "compare", "expect", "stop"];

/// Keys that name files, by the list they are in.
const FILES: [&str; 2] = ["task", "force"];

/// See the module.
#[derive(Clone, Debug)]
pub struct Document {
    pub table: Table,
    /// Where its paths begin: the file that it began with.
    pub file: PathBuf,
}

impl Document {
    /// A run's scenario as that of a session that may last for `end` seconds.
    pub fn of(run: &Run, end: f64) -> Self {
        let mut table = run.written();
        NOT_OF_A_SESSION.iter().for_each(|key| drop(table.remove(*key)));
        table.insert("duration".into(), Value::Float(end));
        // What a repetition changed.
        table.insert("seed".into(), Value::Integer(i64::try_from(run.scenario.seed).unwrap_or(i64::MAX)));
        let mut document = Document { table, file: run.file.clone() };
        let control = document.table.entry("control").or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(control) = control {
            control.insert("idle_ticks".into(), Value::Boolean(true));
        }
        // What is drawn for all of a run stays what it was.
        let span = run.scenario.duration;
        for force in document.list("force") {
            let Value::Table(force) = force else { continue };
            if force.get("type").and_then(Value::as_str) == Some("random-pushes") && !force.contains_key("duration") {
                let start = force.get("start").and_then(as_number).unwrap_or(0.0);
                if span > start {
                    force.insert("duration".into(), Value::Float(span - start));
                }
            }
        }
        document
    }

    /// The entries of a list of tables, which is made if there is none.
    pub fn list(&mut self, key: &str) -> &mut Vec<Value> {
        let list = self.table.entry(key).or_insert_with(|| Value::Array(Vec::new()));
        if !list.is_array() {
            *list = Value::Array(Vec::new());
        }
        match list {
            Value::Array(entries) => entries,
            _ => unreachable!("it was made one"),
        }
    }

    /// As TOML.
    pub fn text(&self) -> String {
        let mut table = self.table.clone();
        // An empty list is none.
        table.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        table.to_string()
    }

    /// The run it describes.
    pub fn run(&self) -> Result<Run, ConsoleError> {
        let wrong = |found| self.wrong(found);
        let file = scenario::parse(&self.file, self.text()).map_err(wrong)?;
        let expansion = file.expansion(&[], 1).map_err(wrong)?;
        let mut only = None;
        expansion.check(&mut |run| only = Some(run)).map_err(wrong)?;
        only.ok_or_else(|| ConsoleError::usage("the scenario has no run"))
    }

    /// What is wrong stands in the text of the session, not in the file that it began with.
    pub fn wrong(&self, mut found: Diagnostics) -> ConsoleError {
        let file = self.file.display().to_string();
        found.0.iter_mut().filter(|one| one.file == file).for_each(|one| one.file = "session".to_owned());
        ConsoleError::Scenario(found)
    }

    /// Writes it as a scenario that ends at `time` seconds. Its paths begin where the file is.
    pub fn save(&self, path: &Path, time: f64) -> Result<(), ConsoleError> {
        let mut saved = self.clone();
        saved.table.insert("stop".into(), Value::Table(Table::from_iter([("at".into(), Value::Float(time))])));
        let (from, to) = (folder(&self.file), folder(path));
        std::fs::create_dir_all(&to).map_err(|source| ConsoleError::Io { path: to.clone(), source })?;
        let lead = |value: Option<&mut Value>| {
            if let Some(Value::String(written)) = value {
                *written = leading(&from, &to, written);
            }
        };
        if let Some(Value::Table(robot)) = saved.table.get_mut("robot") {
            lead(robot.get_mut("model"));
            lead(robot.get_mut("backend_key"));
        }
        for list in FILES {
            saved.list(list).iter_mut().for_each(|entry| lead(entry.get_mut("file")));
        }
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{SESSION} that began with {name}.\n\n{}", saved.text());
        write_named(path, Made::Session, |out| out.write_all(text.as_bytes()).map_err(RecordError::io(path)))?;
        Ok(())
    }
}

/// Puts a value under a dotted key, into the tables that are there.
pub fn put(table: &mut Table, key: &str, value: Value) -> Result<(), ConsoleError> {
    let mut segments = segments(key)?;
    let last = segments.pop().unwrap_or_default();
    let mut table = table;
    for segment in segments {
        let inner = table.entry(segment.clone()).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(inner) = inner else {
            return Err(ConsoleError::usage(format!("`{key}`: `{segment}` is no table")));
        };
        table = inner;
    }
    table.insert(last, value);
    Ok(())
}

/// A TOML number, whole or not.
pub fn as_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn folder(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

/// A path written for one folder, as it is written in another.
fn leading(from: &Path, to: &Path, written: &str) -> String {
    if Path::new(written).is_absolute() || from == to {
        return written.to_owned();
    }
    // Behind links `..` leads elsewhere than it seems.
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| plain(path));
    let (target, to) = (real(&from.join(written)), real(to));
    let (mut a, mut b) = (target.components().peekable(), to.components().peekable());
    while a.peek().is_some() && a.peek() == b.peek() {
        a.next();
        b.next();
    }
    // On other drives there is no relative way.
    if b.clone().any(|part| matches!(part, Component::Prefix(_))) {
        return target.to_string_lossy().into_owned();
    }
    let up = b.map(|_| "..".to_owned());
    let down = a.map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// The path without `.` and `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
        plain
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lead_where_they_led() {
        let way = |from: &str, to: &str, written: &str| leading(Path::new(from), Path::new(to), written);
        assert_eq!(way("/a/scenarios", "/a/scenarios", "../robots/x.toml"), "../robots/x.toml");
        assert_eq!(way("/a/scenarios", "/a", "../robots/x.toml"), "robots/x.toml");
        assert_eq!(way("/a/scenarios", "/b/c", "./t.luau"), "../../a/scenarios/t.luau");
        assert_eq!(way("/a", "/b", "/r/x.toml"), "/r/x.toml");
    }

    #[test]
    fn values_are_put_into_tables() {
        let mut table = Table::new();
        put(&mut table, "a.b", Value::Integer(1)).unwrap();
        put(&mut table, "a.c", Value::Integer(2)).unwrap();
        assert_eq!(table.to_string(), "[a]\nb = 1\nc = 2\n");
        assert!(put(&mut table, "a.b.c", Value::Integer(1)).is_err());
    }
}
