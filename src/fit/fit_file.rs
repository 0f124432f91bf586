//! Fit files: reading, and the checks that need no data.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::fit::format::{FitSpec, Scale};
use crate::input;
use crate::scenario::{Findings, KeyPath, NodeDeserializer};
use crate::text::source::{Sources, Span};
use crate::text::suggest;
use crate::text::toml_tree::Node;
use crate::text::{Diagnostic, Diagnostics};

/// Greatest number of parameters: each takes two runs of each data set per iteration.
pub const MAX_PARAMETERS: usize = 100;

/// A fit file whose values are in their ranges.
#[derive(Clone, Debug)]
pub struct FitFile {
    /// Path as the user gave it.
    pub path: PathBuf,
    /// Its values.
    pub spec: FitSpec,
    sources: Sources,
    root: Node,
}

impl FitFile {
    /// Reads a fit file.
    ///
    /// # Errors
    /// The file cannot be read or is not valid; all errors that can be found.
    pub fn load(path: &Path) -> Result<Self, Diagnostics> {
        let name = path.display().to_string();
        let text = input::read_text(path, input::MOST_TEXT)
            .map_err(|error| Diagnostic::whole_file(name, format!("cannot read the file: {error}")))?;
        Self::parse(path, &text)
    }

    /// Reads a fit file from its text; `path` names it, and relative paths in it start at its folder.
    ///
    /// # Errors
    /// See [`FitFile::load`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        let mut sources = Sources::default();
        let start = sources.add(path, text);
        let mut findings = Findings::default();
        let (root, errors) = Node::parse(text, start);
        findings.syntax(errors);
        if findings.has_errors() {
            return Err(findings.into_diagnostics(&sources));
        }
        let spec = match FitSpec::deserialize(NodeDeserializer(&root)) {
            Ok(spec) => spec,
            Err(error) => {
                error.at(&root.span).report_in("the fit", &mut findings);
                return Err(findings.into_diagnostics(&sources));
            }
        };
        let file = FitFile { path: path.to_owned(), spec, sources, root };
        file.check(&mut findings);
        if findings.has_errors() { Err(findings.into_diagnostics(&file.sources)) } else { Ok(file) }
    }

    /// The name of the fit: the file's, without its ending.
    pub fn name(&self) -> String {
        stem(&self.path)
    }

    /// The name of a data set.
    pub fn data_name(&self, index: usize) -> String {
        let data = &self.spec.data[index];
        data.name.clone().unwrap_or_else(|| stem(Path::new(&data.file)))
    }

    /// A path that is written in this file.
    pub fn resolve(&self, written: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(written)
    }

    /// An error about the value at a dotted path, such as `parameter.0.key`.
    pub fn error_at(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Box<Diagnostic> {
        Box::new(Diagnostic::error(&self.sources, &self.span(path), message, help))
    }

    fn span(&self, path: &str) -> Span {
        KeyPath::internal(path).locate(&self.root).1
    }

    fn check(&self, findings: &mut Findings) {
        let mut error = |path: &str, message: String, help: Option<String>| {
            findings.error(self.span(path), message, help);
        };
        for key in ["data", "parameter", "signal"] {
            let length = self.root.get(key).map_or(0, |list| list.items().len());
            if length == 0 {
                error(key, format!("the fit has no `[[{key}]]`"), None);
            }
        }
        if self.spec.parameter.len() > MAX_PARAMETERS {
            let message = format!("`parameter` has {} entries, at most {MAX_PARAMETERS}", self.spec.parameter.len());
            error("parameter", message, None);
        }
        for (i, parameter) in self.spec.parameter.iter().enumerate() {
            let at = |key: &str| format!("parameter.{i}.{key}");
            let (low, high) = (parameter.min, parameter.max);
            if parameter.key.all().is_empty() {
                error(&at("key"), format!("`{}` must name a key", at("key")), None);
            }
            if !(low < high) {
                error(&at("max"), format!("`{}` must be above `min`, {low}, not {high}", at("max")), None);
            } else if !(low..=high).contains(&parameter.start) {
                let message = format!("`{}` must be from {low} to {high}, not {}", at("start"), parameter.start);
                error(&at("start"), message, None);
            }
            if parameter.scale == Scale::Log && !(low > 0.0) {
                let message = format!("`{}` must be greater than 0 on a logarithmic scale, not {low}", at("min"));
                error(&at("min"), message, None);
            }
            for (j, earlier) in self.spec.parameter[..i].iter().enumerate() {
                let same = |key: &&String| {
                    let path = KeyPath::internal(key);
                    earlier.key.all().iter().any(|other| path.overlaps(&KeyPath::internal(other)))
                };
                if let Some(key) = parameter.key.all().iter().find(same) {
                    let message = format!("`{}` and `parameter.{j}.key` both set `{key}`", at("key"));
                    error(&at("key"), message, None);
                }
            }
        }
        let names: Vec<String> = (0..self.spec.data.len()).map(|i| self.data_name(i)).collect();
        for (i, data) in self.spec.data.iter().enumerate() {
            if let Some(j) = names[..i].iter().position(|name| *name == names[i]) {
                let key = if data.name.is_some() { "name" } else { "file" };
                let message = format!("`data.{i}` and `data.{j}` have the same name `{}`", names[i]);
                error(&format!("data.{i}.{key}"), message, Some("give each a `name`".into()));
            }
            if let (Some(from), Some(to)) = (data.from, data.to)
                && !(from < to)
            {
                error(&format!("data.{i}.to"), format!("`data.{i}.to` must be after `from`, {from}, not {to}"), None);
            }
        }
        if !self.spec.data.is_empty() && self.spec.data.iter().all(|data| data.hold_out) {
            error("data", "all data are held out: there is nothing to fit".into(), None);
        }
        for (i, signal) in self.spec.signal.iter().enumerate() {
            for (k, name) in signal.data.iter().flatten().enumerate() {
                if !names.contains(name) {
                    let help = suggest::help(name, names.iter().map(String::as_str));
                    error(&format!("signal.{i}.data.{k}"), format!("there are no data `{name}`"), Some(help));
                }
            }
            if signal.sigma.is_some() != self.spec.signal[0].sigma.is_some() {
                let message = format!("`signal.{i}` and `signal.0` must both have a `sigma`, or none");
                let help = "without `sigma` the noise of each signal is estimated";
                error(&format!("signal.{i}"), message, Some(help.into()));
            }
        }
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}
