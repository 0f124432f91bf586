//! Scenario files: reading, name, and paths relative to the file.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use super::scenario;
use crate::input;
use crate::scenario::findings::Findings;
use crate::text::diagnostic::{Diagnostic, Diagnostics};
use crate::text::source::Sources;
use crate::text::toml_tree::Node;

/// A scenario file with valid TOML. Its values are checked by [`ScenarioFile::expand`], since
/// overrides and sweeps may change any of them.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    /// Path as the user gave it.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    pub(super) sources: Sources,
    pub(super) root: Arc<Node>,
}

/// Reads a scenario file.
///
/// # Errors
/// The file cannot be read, is not UTF-8, is not TOML, holds a number that is not finite, or has
/// another format version. All errors that can be found are reported.
pub fn load(path: &Path) -> Result<ScenarioFile, Diagnostics> {
    let name = path.display().to_string();
    check_name(path)?;
    let bytes = input::read(path, input::MOST_TEXT)
        .map_err(|error| Diagnostic::whole_file(&name, format!("cannot read the file: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let mut sources = Sources::default();
        sources.add(&name, String::from_utf8_lossy(error.as_bytes()));
        Diagnostic::error(&sources, &(at..at), "the file is not UTF-8 from here on", None)
    })?;
    parse(path, text)
}

/// Parses a scenario from a text. Diagnostics name `path`, and relative paths start from its
/// folder.
///
/// # Errors
/// See [`load`].
pub fn parse(path: &Path, text: impl Into<String>) -> Result<ScenarioFile, Diagnostics> {
    check_name(path)?;
    let text = text.into();
    let mut sources = Sources::default();
    let start = sources.add(path.display().to_string(), &text);
    let mut findings = Findings::default();
    let (root, errors) = Node::parse(&text, start);
    findings.syntax(errors);
    if !findings.has_errors() {
        scenario::check_format(&root, &mut findings);
    }
    if findings.has_errors() {
        return Err(findings.into_diagnostics(&sources));
    }
    Ok(ScenarioFile { path: path.to_owned(), text, sources, root: Arc::new(root) })
}

/// Refuses file names that cannot name a folder of results.
fn check_name(path: &Path) -> Result<(), Diagnostics> {
    match path.file_stem() {
        Some(stem) if stem == "." || stem == ".." => {
            let message = "its name without `.toml` names its folder of results and cannot be `.` or `..`";
            Err(Diagnostic::whole_file(path.display().to_string(), message).into())
        }
        _ => Ok(()),
    }
}

impl ScenarioFile {
    /// The name of the scenario: the file's name without its extension.
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(|| "scenario".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// The file as a plain TOML table, sweep included, without defaults.
    pub fn table(&self) -> toml::Table {
        self.root.to_table()
    }

    /// Resolves a path written in this file, relative to the file's folder.
    pub fn resolve(&self, written: impl AsRef<Path>) -> PathBuf {
        resolve(&self.path, written.as_ref())
    }
}

/// A path written in `file`.
pub(super) fn resolve(file: &Path, written: &Path) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(written)
}
