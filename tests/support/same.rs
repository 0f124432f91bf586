//! Compares two folders of results bit for bit, except for measured times.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::place::Table;

/// Columns of the summary that differ between equal runs.
pub fn is_time(column: &str) -> bool {
    ["wall_s", "real_time_factor"].contains(&column) || column.ends_with("cpu_s") || column.starts_with("timing_")
}

/// Relative paths of all files below a folder, sorted.
pub fn files(folder: &Path) -> Vec<String> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(current) = folders.pop() {
        for entry in fs::read_dir(current).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    files.sort();
    files
}

/// Rows of a summary in file order, without times.
pub fn rows(table: &Table) -> Vec<Vec<(String, String)>> {
    let row = |cells: &Vec<String>| {
        let named = table.header.iter().cloned().zip(cells.iter().cloned());
        named.filter(|(name, _)| !is_time(name)).collect()
    };
    table.rows.iter().map(row).collect()
}

/// Reads a record without times.
fn record(path: &Path) -> Value {
    let mut record: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    record.as_object_mut().unwrap().remove("timing").expect("a record with times");
    record.as_object_mut().unwrap().remove("checksum").expect("a record with a checksum");
    record
}

/// Lines of `runs.jsonl` by scenario and key, without times. Their order in the file is the order
/// in which the runs ended, so it may differ between equal batches.
fn lines(path: &Path) -> BTreeMap<(String, String), Value> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = BTreeMap::new();
    for line in text.lines() {
        let mut line: Value = serde_json::from_str(line).unwrap();
        line.as_object_mut().unwrap().retain(|name, _| !is_time(name) && name != "checksum");
        let field = |name: &str| line[name].as_str().unwrap().to_owned();
        let previous = lines.insert((field("scenario"), field("key")), line);
        assert!(previous.is_none(), "{} has two lines for a run", path.display());
    }
    lines
}

/// Asserts that two folders hold the same results.
#[track_caller]
pub fn assert_same(a: &Path, b: &Path) {
    assert_eq!(files(a), files(b), "{} and {}", a.display(), b.display());
    for file in files(a) {
        let (a, b) = (a.join(&file), b.join(&file));
        match a.file_name().unwrap().to_str().unwrap() {
            "run.json" => assert_eq!(record(&a), record(&b), "{file}"),
            "runs.jsonl" => assert_eq!(lines(&a), lines(&b)),
            "summary.csv" => {
                let (a, b) = (Table::read(&a), Table::read(&b));
                assert_eq!(a.header, b.header);
                assert_eq!(rows(&a), rows(&b));
            }
            // Both contain times; their other values are those of summary.csv.
            "summary.parquet" | "report.html" => {}
            _ => assert!(fs::read(&a).unwrap() == fs::read(&b).unwrap(), "{file} differs"),
        }
    }
}
