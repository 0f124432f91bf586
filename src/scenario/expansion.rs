//! Expands a scenario file to its runs, one at a time: a sweep of millions is never in memory.

use std::{
    ops::Range,
    sync::{Arc, Mutex, PoisonError},
};

use super::file::ScenarioFile;
use super::inputs::{Files, Input};
use super::reference::Reference;
use super::run::{Origin, Run};
use super::scenario::{self, Scenario};
use super::sweep::{Cell, Grid};
use super::{events, overrides};
use crate::contact::methods::registry::METHODS;
use crate::scenario::findings::Findings;
use crate::scenario::key_path::KeyPath;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::text::source::{Sources, Span};
use crate::text::toml_tree::Node;

/// Number of errors after which an expansion stops.
const MAX_ERRORS: usize = 50;

/// Number of repetitions that are created in one pass over their values.
const REPETITIONS_PER_PASS: u32 = 64;

/// A file with its overrides and its sweep; creates each run by its number.
pub struct Expansion {
    file: ScenarioFile,
    sources: Sources,
    base: Arc<Node>,
    grid: Grid,
    /// Files read so far; their bytes do not change between runs.
    files: Mutex<Files>,
}

impl ScenarioFile {
    /// Reads overrides and sweep; the runs are checked by [`Expansion::check`].
    ///
    /// # Errors
    /// Errors in the overrides or in the sweep itself; more than `max_runs` runs.
    pub fn expansion(&self, overrides: &[(String, toml::Value)], max_runs: usize) -> Result<Expansion, Diagnostics> {
        let mut sources = self.sources.clone();
        let mut findings = Findings::default();
        let mut base = Node::clone(&self.root);
        let fixed = overrides::apply(&mut base, overrides, &mut sources, &mut findings);
        if findings.has_errors() {
            return Err(findings.into_diagnostics(&sources));
        }
        let grid = Grid::read(&base, &fixed, &sources, max_runs, &mut findings);
        if findings.has_errors() {
            // Errors outside the sweep are reported together with those in it.
            findings.append(scenario::read(&base).1);
            return Err(findings.into_diagnostics(&sources));
        }
        base.remove("sweep");
        Ok(Expansion { file: self.clone(), sources, base: Arc::new(base), grid, files: Mutex::default() })
    }
}

impl Expansion {
    /// The file.
    pub fn file(&self) -> &ScenarioFile {
        &self.file
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.grid.runs()
    }

    /// Creates each run in order and passes it to `consume`. A warning that several runs share is
    /// reported with the first of them. Returns the warnings about the file as a whole.
    ///
    /// # Errors
    /// The errors of all runs.
    pub fn check(&self, consume: &mut dyn FnMut(Run)) -> Result<Diagnostics, Diagnostics> {
        let mut findings = Findings::default();
        let mut unused = UnusedParameters::default();
        let repeat = self.grid.repeat;
        let parts = |cell| {
            (0..repeat)
                .step_by(REPETITIONS_PER_PASS as usize)
                .map(move |at| (cell, at..repeat.min(at + REPETITIONS_PER_PASS)))
        };
        for (cell, repetitions) in (0..self.grid.cells()).flat_map(parts) {
            let runs = self.cell(cell, repetitions, &mut findings);
            if findings.errors() >= MAX_ERRORS {
                break;
            }
            for run in runs.unwrap_or_default() {
                unused.check(&run);
                consume(run);
            }
        }
        if findings.has_errors() { Err(findings.into_diagnostics(&self.sources)) } else { Ok(unused.warnings()) }
    }

    /// One run by its number, from 0; `None` if there is no such run or it has an error.
    pub fn run(&self, number: usize) -> Option<Run> {
        let repeat = self.grid.repeat.max(1);
        let repetition = (number % repeat as usize) as u32;
        let runs = self.cell(number / repeat as usize, repetition..repetition + 1, &mut Findings::default());
        runs?.pop().filter(|_| number < self.runs())
    }

    /// Some repetitions of a combination of values; `None` after an error, which goes to
    /// `findings`.
    fn cell(&self, number: usize, repetitions: Range<u32>, findings: &mut Findings) -> Option<Vec<Run>> {
        let (sources, cell) = (&self.sources, self.grid.cell(number));
        let swept = cell.values();
        let mut root = Node::clone(&self.base);
        let mut found = Findings::default();
        for (path, value) in &swept {
            if let Err(error) = path.set(&mut root, value.clone()) {
                found.error(error.span, error.message, None);
            }
        }
        let (scenario, read) = scenario::read(&root);
        found.append(read);
        found.explain(|span| replaced_position(span, &swept, &self.base, sources));
        let mut warnings = findings.append(found).into_diagnostics(sources);
        let mut reference = Reference::read(&root, sources, findings);
        let reference_warnings = reference.as_mut().map(|r| std::mem::take(&mut r.warnings)).unwrap_or_default();
        warnings.0.extend(reference_warnings.into_diagnostics(sources).0);
        let scenario = scenario?;
        let (inputs, reference_inputs) = {
            let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
            let mut read = |scenario: &Scenario| files.read(scenario, &self.file.path, &root, findings);
            (read(&scenario), reference.as_ref().map(|r| read(&r.scenario)).unwrap_or_default())
        };
        let parts = CellParts { expansion: self, root: &root, swept: &swept };
        let mut runs = Vec::new();
        for repetition in repetitions {
            let index = number * self.grid.repeat as usize + repetition as usize;
            let seeded =
                |scenario: &Scenario, by: u32| Scenario { seed: scenario.seed + u64::from(by), ..scenario.clone() };
            let reference = match &reference {
                Some(reference) => {
                    let by = if reference.fixes_seed() { 0 } else { repetition };
                    let scenario = seeded(&reference.scenario, by);
                    let (run, _) = parts.run(index, scenario, &reference_inputs, &reference.values, findings)?;
                    Some(Box::new(run))
                }
                None => None,
            };
            let (run, table) = parts.run(index, seeded(&scenario, repetition), &inputs, &[], findings)?;
            let (parameters, warnings) = (Cell::parameters(&cell, &root, &table), std::mem::take(&mut warnings));
            runs.push(Run { parameters, warnings, reference, ..run });
        }
        Some(runs)
    }
}

/// Data that all runs of a cell share.
struct CellParts<'a> {
    expansion: &'a Expansion,
    root: &'a Node,
    swept: &'a [(KeyPath, Node)],
}

impl CellParts<'_> {
    fn run(
        &self,
        index: usize,
        scenario: Scenario,
        inputs: &[Input],
        values: &[(KeyPath, Node)],
        findings: &mut Findings,
    ) -> Option<(Run, toml::Table)> {
        let Expansion { file, sources, base, .. } = self.expansion;
        match resolved(&scenario) {
            Ok((resolved_toml, table)) => {
                let mut run = Run {
                    name: file.name(),
                    file: file.path.clone(),
                    index,
                    resolved_toml,
                    scenario,
                    parameters: Vec::new(),
                    warnings: Diagnostics::default(),
                    reference: None,
                    inputs: inputs.to_vec(),
                    events: Vec::new(),
                    origin: Origin {
                        sources: sources.clone(),
                        base: base.clone(),
                        swept: self.swept.iter().chain(values).cloned().collect(),
                        reported: Arc::default(),
                    },
                };
                // With errors among the findings the run is dropped.
                run.events = events::read(&run, sources, findings).unwrap_or_default();
                Some((run, table))
            }
            Err(error) => {
                findings.error(KeyPath::internal("seed").locate(self.root).1, error.to_string(), None);
                None
            }
        }
    }
}

/// Parameters of contact methods that no run of the file uses.
#[derive(Default)]
struct UnusedParameters {
    used: Vec<&'static str>,
    /// The warning about each method, from the first run that gives its parameters.
    warnings: Vec<(&'static str, Diagnostic)>,
}

impl UnusedParameters {
    fn check(&mut self, run: &Run) {
        let contact = &run.scenario.contact;
        let used = contact.method.name();
        if !self.used.contains(&used) {
            self.used.push(used);
        }
        let parameters = contact.parameters();
        for name in METHODS.iter().filter(|method| (method.is_configured)(&parameters)).map(|method| method.name) {
            if self.warnings.iter().any(|(known, _)| *known == name) {
                continue;
            }
            let message = format!("`contact.{name}` has no effect: `contact.method` is \"{used}\"");
            let warning = run.diagnose(&format!("contact.{name}"), Severity::Warning, true, message, None);
            self.warnings.push((name, warning));
        }
    }

    fn warnings(mut self) -> Diagnostics {
        self.warnings.retain(|(name, _)| !self.used.contains(name));
        self.warnings.sort_by_key(|(name, _)| METHODS.iter().position(|method| method.name == *name));
        Diagnostics(self.warnings.into_iter().map(|(_, warning)| warning).collect())
    }
}

/// For an error in a swept value: the position in the file that the value replaces.
fn replaced_position(span: &Span, swept: &[(KeyPath, Node)], base: &Node, sources: &Sources) -> Option<String> {
    let within = |outer: &Span| outer.start <= span.start && span.end <= outer.end;
    let (path, _) =
        swept.iter().find(|(path, value)| within(&value.span) || path.segments.iter().any(|s| within(&s.1)))?;
    let name = |count: usize| path.segments[..count].iter().map(|s| s.0.as_str()).collect::<Vec<_>>().join(".");
    let existing = (1..=path.segments.len()).rev().find(|count| path.prefix(*count).get(base).is_some());
    let Some(count) = existing else {
        return Some(format!("the file itself has no `{}`", name(1)));
    };
    let (key, value) = path.prefix(count).locate(base);
    let location = Diagnostic::error(sources, &key, "", None).location();
    // The error of an overridden key already shows its only position.
    let is_same = within(&value);
    (!is_same).then(|| format!("`{}` is at {location}", name(count)))
}

/// Why a scenario cannot be written as TOML.
#[derive(Debug, thiserror::Error)]
enum ResolveError {
    #[error("`seed` with its repetitions reaches {0}, which TOML cannot hold")]
    Seed(u64),
    #[error("the scenario cannot be written as TOML: {0}")]
    Toml(#[from] toml::ser::Error),
}

/// The scenario with every value written out, as a text and as a table.
fn resolved(scenario: &Scenario) -> Result<(String, toml::Table), ResolveError> {
    if i64::try_from(scenario.seed).is_err() {
        return Err(ResolveError::Seed(scenario.seed));
    }
    Ok((toml::to_string(scenario)?, toml::Table::try_from(scenario)?))
}
