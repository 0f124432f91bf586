//! `searches.json`: the results of searches with their runs. `searches.csv`: a row for each.
//! `boundary-lines.csv`: a row for each point of a boundary over two keys.

use crate::files::{RecordError, atomic, if_present, json, names};
use crate::input;
use crate::results::PROGRAM;
use crate::results::searches::search_result::SearchResult;
use crate::text::csv_line::csv_line;
use serde::de::Error;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Format version of `searches.json`.
pub const SEARCHES_SCHEMA: u32 = 1;

/// The file.
#[derive(Serialize, Deserialize)]
struct SearchesFile {
    schema: u32,
    program: String,
    searches: Vec<SearchResult>,
}

/// Writes the results of searches into a folder of results, and returns the files: none without
/// searches, `boundary-lines.csv` only where there are lines.
///
/// # Errors
/// A file cannot be written.
pub fn write_searches(results: &Path, searches: &[SearchResult]) -> Result<Vec<PathBuf>, RecordError> {
    if searches.is_empty() {
        return Ok(Vec::new());
    }
    let path = |name: &str| results.join(name);
    let mut tables = vec![(path(names::SEARCHES_CSV), csv(searches))];
    let lines = path(names::BOUNDARY_LINES);
    if searches.iter().any(|search| !search.lines.is_empty()) {
        tables.push((lines, csv_of_lines(searches)));
    } else {
        if_present(std::fs::remove_file(&lines)).map_err(RecordError::io(&lines))?;
    }
    let (schema, program) = (SEARCHES_SCHEMA, PROGRAM.to_owned());
    let all = path(names::SEARCHES);
    json::write_pretty(&all, &SearchesFile { schema, program, searches: searches.to_vec() })?;
    for (file, table) in &tables {
        atomic::write(file, |out| out.write_all(table.as_bytes()).map_err(RecordError::io(file)))?;
    }
    Ok(tables.into_iter().map(|(file, _)| file).chain([all]).collect())
}

/// Reads the results of searches in a folder of results; none without a file.
///
/// # Errors
/// The file cannot be read, is of another version, or contradicts itself.
pub fn read_searches(results: &Path) -> Result<Vec<SearchResult>, RecordError> {
    let path = results.join(names::SEARCHES);
    match input::read(&path, input::MOST_DATA) {
        Ok(bytes) => {
            let searches = json::parse::<SearchesFile>(&bytes, &path, SEARCHES_SCHEMA)?.searches;
            match searches.iter().position(|search| !search.is_consistent()) {
                Some(i) => {
                    let reason = format!("search {i} has values of more or fewer keys than it names");
                    Err(RecordError::Json { path, source: serde_json::Error::custom(reason) })
                }
                None => Ok(searches),
            }
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(RecordError::io(&path)(error)),
    }
}

/// Swept keys of all searches.
fn swept(searches: &[SearchResult]) -> BTreeSet<&str> {
    searches.iter().flat_map(|search| search.parameters.keys()).map(String::as_str).collect()
}

fn swept_values<'a>(search: &'a SearchResult, keys: &'a BTreeSet<&str>) -> impl Iterator<Item = String> + 'a {
    keys.iter().map(|key| search.parameters.get(*key).map_or_else(String::new, ToString::to_string))
}

fn number(x: Option<f64>) -> String {
    x.map_or_else(String::new, |x| x.to_string())
}

/// A row for each search, with a column for each swept key, and one for the best value of each
/// searched key.
fn csv(searches: &[SearchResult]) -> String {
    let keys = swept(searches);
    let optima = || searches.iter().filter(|search| search.best.is_some());
    let searched: BTreeSet<&str> = optima().flat_map(|search| &search.keys).map(String::as_str).collect();
    let own = ["search", "subject", "over", "verdict", "lower", "upper", "holds_above", "best"];
    let names = ["scenario"].into_iter().chain(keys.iter().copied()).chain(own).chain(searched.iter().copied());
    let mut out = csv_line(names.chain(["runs", "message"]).map(str::to_owned));
    for search in searches {
        let interval = search.interval.as_ref();
        let best = |key: &&str| {
            let at = search.keys.iter().position(|own| own == key)?;
            search.best.as_ref()?.at.get(at).copied()
        };
        let own = [
            search.search.name().to_owned(),
            search.subject.clone(),
            search.keys.join(" "),
            search.verdict.name().to_owned(),
            number(interval.map(|interval| interval.lower)),
            number(interval.map(|interval| interval.upper)),
            interval.map_or_else(String::new, |interval| interval.holds_above.to_string()),
            number(search.best.as_ref().map(|best| best.value)),
        ];
        let cells = [search.scenario.clone()].into_iter().chain(swept_values(search, &keys)).chain(own);
        let cells = cells.chain(searched.iter().map(|key| number(best(key))));
        out += &csv_line(cells.chain([search.runs.to_string(), search.message.clone()]));
    }
    out
}

/// A row for each point of a line: the two pairs of values between which the condition changes.
fn csv_of_lines(searches: &[SearchResult]) -> String {
    let keys = swept(searches);
    let own = ["subject", "line", "x", "y", "x_lower", "x_upper", "y_lower", "y_upper", "holds_above"];
    let names = ["scenario"].into_iter().chain(keys.iter().copied()).chain(own);
    let mut out = csv_line(names.map(str::to_owned));
    for search in searches {
        let [x, y] = [0, 1].map(|i| search.keys.get(i).cloned().unwrap_or_default());
        for (number, points) in search.lines.iter().enumerate() {
            for point in points {
                let own = [search.subject.clone(), number.to_string(), x.clone(), y.clone()];
                let ends = [0, 1].into_iter().flat_map(|i| [point.lower[i], point.upper[i]]).map(|x| x.to_string());
                let cells = [search.scenario.clone()].into_iter().chain(swept_values(search, &keys)).chain(own);
                out += &csv_line(cells.chain(ends).chain([point.holds_above.to_string()]));
            }
        }
    }
    out
}
