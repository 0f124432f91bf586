//! TOML scenario of a session: edited by commands, built like any scenario, saved with `stop.at`.

use std::path::{Component, Path, PathBuf};

use toml::{Table, Value};

use crate::console::ConsoleError;
use crate::console::arguments::segments;
use crate::files::{OutputKind, RecordError, SESSION, write_named};
use crate::scenario::{self, Diagnostics, Run};
use std::io::Write;

/// Keys of a batch, and rules that would end a session; removed from the scenario.
const REMOVED_KEYS: [&str; 4] = ["sweep", "compare", "expect", "stop"];

/// Lists whose entries have a path in the key `file`, or `model`.
const FILES: [&str; 4] = ["task", "force", "terrain", "object"];

/// Scenario of a session as a TOML table.
#[derive(Clone, Debug)]
pub struct ScenarioDocument {
    pub table: Table,
    /// The scenario file; paths in the table are relative to its folder.
    pub file: PathBuf,
}

impl ScenarioDocument {
    /// Scenario of a session from that of a run, with the longest duration `end`, s.
    pub fn of(run: &Run, end: f64) -> Self {
        let mut table = run.written_values();
        REMOVED_KEYS.iter().for_each(|key| drop(table.remove(*key)));
        table.insert("duration".into(), Value::Float(end));
        // Each repetition has its own seed.
        table.insert("seed".into(), Value::Integer(i64::try_from(run.scenario.seed).unwrap_or(i64::MAX)));
        table.insert("stop".into(), Value::Table(continuing()));
        let mut document = ScenarioDocument { table, file: run.file.clone() };
        let control = document.table.entry("control").or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(control) = control {
            control.insert("idle_ticks".into(), Value::Boolean(true));
        }
        // Random pushes are drawn for their whole span, so keep the span of the original run.
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

    /// Entries of a list of tables; an absent list is created.
    pub fn list(&mut self, key: &str) -> &mut Vec<Value> {
        let list = self.table.entry(key).or_insert_with(|| Value::Array(Vec::new()));
        if !list.is_array() {
            *list = Value::Array(Vec::new());
        }
        match list {
            Value::Array(entries) => entries,
            _ => unreachable!("replaced by an array above"),
        }
    }

    /// TOML text.
    pub fn text(&self) -> String {
        let mut table = self.table.clone();
        // Omit empty lists.
        table.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        table.to_string()
    }

    /// Reads the document as a scenario and returns its run.
    pub fn run(&self) -> Result<Run, ConsoleError> {
        let wrong = |found| self.scenario_error(found);
        let file = scenario::parse(&self.file, self.text()).map_err(wrong)?;
        let expansion = file.expansion(&[], 1).map_err(wrong)?;
        let mut only = None;
        expansion.check(&mut |run| only = Some(run)).map_err(wrong)?;
        only.ok_or_else(|| ConsoleError::usage("the scenario has no run"))
    }

    /// Attributes diagnostics of the scenario file to the session, whose text differs from the
    /// file.
    pub fn scenario_error(&self, mut found: Diagnostics) -> ConsoleError {
        let file = self.file.display().to_string();
        found.0.iter_mut().filter(|one| one.file == file).for_each(|one| one.file = "session".to_owned());
        ConsoleError::Scenario(found)
    }

    /// Writes a scenario that ends at `time`, s, with paths relative to the folder of `path`.
    pub fn save(&self, path: &Path, time: f64) -> Result<(), ConsoleError> {
        let mut saved = self.clone();
        let mut stop = continuing();
        stop.insert("at".into(), Value::Float(time));
        saved.table.insert("stop".into(), Value::Table(stop));
        let (from, to) = (folder(&self.file), folder(path));
        std::fs::create_dir_all(&to).map_err(|source| ConsoleError::Io { path: to.clone(), source })?;
        let rebase = |value: Option<&mut Value>| {
            if let Some(Value::String(path)) = value {
                *path = rebased(&from, &to, path);
            }
        };
        if let Some(Value::Table(robot)) = saved.table.get_mut("robot") {
            rebase(robot.get_mut("model"));
            rebase(robot.get_mut("backend_key"));
        }
        for list in FILES {
            for entry in saved.list(list) {
                rebase(entry.get_mut("file"));
                rebase(entry.get_mut("model"));
            }
        }
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{SESSION} that started from {name}.\n\n{}", saved.text());
        write_named(path, OutputKind::Session, |out| out.write_all(text.as_bytes()).map_err(RecordError::io(path)))?;
        Ok(())
    }
}

/// Rules of a session, which continues after a fall.
fn continuing() -> Table {
    Table::from_iter([("sunk_link".into(), Value::String("ignore".into()))])
}

/// Sets the value of a dotted key; absent tables are created.
pub fn put(table: &mut Table, key: &str, value: Value) -> Result<(), ConsoleError> {
    let mut segments = segments(key)?;
    let last = segments.pop().unwrap_or_default();
    let mut table = table;
    for segment in segments {
        let inner = table.entry(segment.clone()).or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(inner) = inner else {
            return Err(ConsoleError::usage(format!("`{key}`: `{segment}` is not a table")));
        };
        table = inner;
    }
    table.insert(last, value);
    Ok(())
}

/// Value of a TOML float or integer.
pub fn as_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn folder(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

/// Rewrites a path relative to the folder `from` as relative to the folder `to`.
fn rebased(from: &Path, to: &Path, written: &str) -> String {
    if Path::new(written).is_absolute() || from == to {
        return written.to_owned();
    }
    // Resolve symbolic links: `..` after a link is not the folder that contains the link.
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| plain(path));
    let (target, to) = (real(&from.join(written)), real(to));
    let (mut a, mut b) = (target.components().peekable(), to.components().peekable());
    while a.peek().is_some() && a.peek() == b.peek() {
        a.next();
        b.next();
    }
    // There is no relative path between drives.
    if b.clone().any(|part| matches!(part, Component::Prefix(_))) {
        return target.to_string_lossy().into_owned();
    }
    let up = b.map(|_| "..".to_owned());
    let down = a.map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// Removes `.` and `..` from a path.
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
    fn rebased_paths_name_the_same_files() {
        let path = |from: &str, to: &str, written: &str| rebased(Path::new(from), Path::new(to), written);
        assert_eq!(path("/a/scenarios", "/a/scenarios", "../robots/x.toml"), "../robots/x.toml");
        assert_eq!(path("/a/scenarios", "/a", "../robots/x.toml"), "robots/x.toml");
        assert_eq!(path("/a/scenarios", "/b/c", "./t.luau"), "../../a/scenarios/t.luau");
        assert_eq!(path("/a", "/b", "/r/x.toml"), "/r/x.toml");
    }

    #[test]
    fn put_sets_values_of_dotted_keys() {
        let mut table = Table::new();
        put(&mut table, "a.b", Value::Integer(1)).unwrap();
        put(&mut table, "a.c", Value::Integer(2)).unwrap();
        assert_eq!(table.to_string(), "[a]\nb = 1\nc = 2\n");
        assert!(put(&mut table, "a.b.c", Value::Integer(1)).is_err());
    }
}
