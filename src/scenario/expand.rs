//! From one file to its runs: overrides, then every combination of the swept values, each judged as a whole.

use std::{
    path::{Path as FsPath, PathBuf},
    sync::Arc,
};

use super::{
    diagnostic::{Diagnostic, Diagnostics, Findings, Severity},
    events::{self, Event},
    file::{ScenarioFile, resolve},
    grid::Grid,
    inputs::{Files, Input},
    overrides,
    path::Path,
    reference::Reference,
    scenario::{self, Scenario},
    source::{Sources, Span},
    spec::contact::{ContactMethod, LcpSpec, NcpSpec, PenaltySpec},
    tree::Node,
};

/// The most runs a file may expand to when nothing else is said.
pub const DEFAULT_MAX_RUNS: usize = 10_000;

/// Errors after which an expansion gives up.
const MAX_ERRORS: usize = 50;

/// One run of a scenario, everything decided.
#[derive(Clone, Debug)]
pub struct Run {
    /// The scenario's name.
    pub name: String,
    /// The scenario's file, as it was named.
    pub file: PathBuf,
    /// Position among the runs of the file, from 0.
    pub index: usize,
    /// Every value, defaults included.
    pub scenario: Scenario,
    /// The swept values, under their dotted names as written, in the order of the file; a key that only other runs sweep
    /// (`list`) has the value it has here, and is left out where that is a table of defaults. Repetitions differ in
    /// `scenario.seed` and are not listed.
    pub parameters: Vec<(String, toml::Value)>,
    /// `scenario` as TOML; it reads back to the same.
    pub resolved_toml: String,
    /// What is probably not meant. A warning that several runs of a file share stands with the first of them.
    pub warnings: Diagnostics,
    /// The run it is compared with.
    pub reference: Option<Box<Run>>,
    /// The files it names beside its robot.
    pub inputs: Vec<Input>,
    /// What changes while it goes on, in the order in which it happens.
    pub events: Vec<Event>,
    /// Where the values come from.
    pub origin: Origin,
}

/// Where the values of a run were written: the file with its overrides, and what the sweep put into it.
#[derive(Clone, Debug)]
pub struct Origin {
    sources: Sources,
    base: Arc<Node>,
    swept: Vec<(Path, Node)>,
}

impl Origin {
    /// The tree of the values.
    pub(super) fn tree(&self) -> Node {
        let mut root = Node::clone(&self.base);
        for (path, value) in &self.swept {
            // These have been set before, when the run was made.
            let _ = path.set(&mut root, value.clone());
        }
        root
    }

    /// Remembers another value that was set.
    pub(super) fn put(&mut self, path: &Path, value: &Node) {
        self.swept.push((path.clone(), value.clone()));
    }
}

impl Run {
    /// The file that the value at a dotted path (such as `task.0.file`) names.
    pub fn input(&self, key: &str) -> Option<&Input> {
        self.inputs.iter().find(|input| input.key == key)
    }

    /// Where a path written in the scenario leads: relative ones start at the scenario file's folder.
    pub fn resolve(&self, written: impl AsRef<FsPath>) -> PathBuf {
        resolve(&self.file, written.as_ref())
    }

    /// An error about the value at a dotted path (such as `force.0.link`), shown where that value of this run was written,
    /// be it in the file, its sweep or an override. For what can only be told with the robot at hand.
    pub fn error_at(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        self.diagnose(path, Severity::Error, false, message.into(), help)
    }

    /// The same, shown at the key: for names that are keys, such as `task.0.joints.knee`.
    pub fn error_at_key(&self, path: &str, message: impl Into<String>, help: Option<String>) -> Diagnostic {
        self.diagnose(path, Severity::Error, true, message.into(), help)
    }

    fn diagnose(
        &self,
        path: &str,
        severity: Severity,
        at_key: bool,
        message: String,
        help: Option<String>,
    ) -> Diagnostic {
        let (key, value) = Path::internal(path).locate(&self.origin.tree());
        Diagnostic::new(severity, &self.origin.sources, if at_key { &key } else { &value }, message, help)
    }
}

impl ScenarioFile {
    /// The runs of the file, at most [`DEFAULT_MAX_RUNS`]. See [`ScenarioFile::expand_at_most`].
    ///
    /// # Errors
    /// See there.
    pub fn expand(&self, overrides: &[(String, toml::Value)]) -> Result<Vec<Run>, Diagnostics> {
        self.expand_at_most(overrides, DEFAULT_MAX_RUNS)
    }

    /// The runs of the file in a fixed order: the dimensions of the sweep (each key of `grid`, each table of `zip`, `list`,
    /// `random`) are nested in the order of the file, the last one changing fastest, and repetitions change faster still.
    ///
    /// `overrides` are values under dotted paths that replace those of the file, as `--set` gives them. A swept key that
    /// is overridden keeps that one value.
    ///
    /// # Errors
    /// Everything found wrong with any of the runs; more than `max_runs` of them.
    pub fn expand_at_most(
        &self,
        overrides: &[(String, toml::Value)],
        max_runs: usize,
    ) -> Result<Vec<Run>, Diagnostics> {
        let mut sources = self.sources.clone();
        let mut findings = Findings::default();
        let runs = expand(self, overrides, max_runs, &mut sources, &mut findings);
        match runs {
            Some(runs) if !findings.has_errors() => Ok(runs),
            _ => Err(findings.into_diagnostics(&sources)),
        }
    }
}

fn expand(
    file: &ScenarioFile,
    overrides: &[(String, toml::Value)],
    max_runs: usize,
    sources: &mut Sources,
    findings: &mut Findings,
) -> Option<Vec<Run>> {
    let mut base = Node::clone(&file.root);
    let fixed = overrides::apply(&mut base, overrides, sources, findings);
    if findings.has_errors() {
        return None;
    }
    let grid = Grid::read(&base, &fixed, sources, max_runs, findings);
    if findings.has_errors() {
        // Mistakes outside the sweep are told together with those in it.
        findings.append(scenario::read(&base).1);
        return None;
    }
    base.remove("sweep");
    let base = Arc::new(base);
    let mut runs = Vec::with_capacity(grid.runs());
    let mut files = Files::default();
    for cell in 0..grid.cells() {
        let cell = grid.cell(cell);
        let swept = cell.values();
        let mut root = Node::clone(&base);
        let mut found = Findings::default();
        for (path, value) in &swept {
            if let Err(error) = path.set(&mut root, value.clone()) {
                found.error(error.span, error.message, None);
            }
        }
        let (scenario, read) = scenario::read(&root);
        found.append(read);
        found.explain(|span| other_place(span, &swept, &base, sources));
        let mut warnings = findings.append(found).into_diagnostics(sources);
        let reference = Reference::read(&root, sources, findings);
        if findings.errors() >= MAX_ERRORS {
            return None;
        }
        let Some(scenario) = scenario else { continue };
        let inputs = files.of(&scenario, &file.path, &root, findings);
        let of_reference =
            reference.as_ref().map(|r| files.of(&r.scenario, &file.path, &root, findings)).unwrap_or_default();
        for repetition in 0..grid.repeat {
            let mut scenario = scenario.clone();
            scenario.seed += u64::from(repetition);
            let mut make = |scenario: Scenario, inputs: &[Input], values: &[(Path, Node)]| match resolved(&scenario) {
                Ok((resolved_toml, table)) => {
                    let mut run = Run {
                        name: file.name(),
                        file: file.path.clone(),
                        index: runs.len(),
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
                            swept: swept.iter().chain(values).cloned().collect(),
                        },
                    };
                    // What is wrong with them stands among the findings, and no run is made.
                    run.events = events::of(&run, sources, findings).unwrap_or_default();
                    Some((run, table))
                }
                Err(message) => {
                    findings.error(Path::internal("seed").locate(&root).1, message, None);
                    None
                }
            };
            let reference = match &reference {
                Some(reference) => {
                    let mut scenario = reference.scenario.clone();
                    scenario.seed += if reference.fixes_seed() { 0 } else { u64::from(repetition) };
                    Some(Box::new(make(scenario, &of_reference, &reference.values)?.0))
                }
                None => None,
            };
            let (run, table) = make(scenario, &inputs, &[])?;
            let (parameters, warnings) = (cell.parameters(&root, &table), std::mem::take(&mut warnings));
            runs.push(Run { parameters, warnings, reference, ..run });
        }
    }
    warn_of_idle(&mut runs);
    Some(runs)
}

/// Warns, with the first run, of parameters that are given to a contact method that no run of the file uses.
fn warn_of_idle(runs: &mut [Run]) {
    for method in [ContactMethod::Penalty, ContactMethod::Lcp, ContactMethod::Ncp] {
        let told = |r: &Run| match method {
            ContactMethod::Penalty => r.scenario.contact.penalty != PenaltySpec::default(),
            ContactMethod::Lcp => r.scenario.contact.lcp != LcpSpec::default(),
            ContactMethod::Ncp => r.scenario.contact.ncp != NcpSpec::default(),
            ContactMethod::Exact | ContactMethod::OneStep => false,
        };
        if runs.iter().any(|r| r.scenario.contact.method == method) {
            continue;
        }
        let name = method.name();
        let Some(run) = runs.iter().find(|r| told(r)) else { continue };
        let message =
            format!("`contact.{name}` has no effect: `contact.method` is \"{}\"", run.scenario.contact.method.name());
        let warning = run.diagnose(&format!("contact.{name}"), Severity::Warning, true, message, None);
        runs[0].warnings.0.push(warning);
    }
}

/// What stands in the file where a swept value that is wrong was put: the other half of the mistake.
fn other_place(span: &Span, swept: &[(Path, Node)], base: &Node, sources: &Sources) -> Option<String> {
    let within = |outer: &Span| outer.start <= span.start && span.end <= outer.end;
    let (path, _) =
        swept.iter().find(|(path, value)| within(&value.span) || path.segments.iter().any(|s| within(&s.1)))?;
    let name = |count: usize| path.segments[..count].iter().map(|s| s.0.as_str()).collect::<Vec<_>>().join(".");
    let there = (1..=path.segments.len()).rev().find(|count| path.first(*count).get(base).is_some());
    let Some(count) = there else {
        return Some(format!("the file itself has no `{}`", name(1)));
    };
    let (key, value) = path.first(count).locate(base);
    let place = Diagnostic::error(sources, &key, "", None).location();
    // An overridden key is shown where it was overridden, and that is all there is to say.
    let one_place = within(&value);
    (!one_place).then(|| format!("`{}` is at {place}", name(count)))
}

/// The scenario with every value written out, as a text and as a table.
fn resolved(scenario: &Scenario) -> Result<(String, toml::Table), String> {
    if i64::try_from(scenario.seed).is_err() {
        return Err(format!("`seed` with its repetitions reaches {}, which TOML cannot hold", scenario.seed));
    }
    let wrong = |error: toml::ser::Error| format!("the scenario cannot be written out: {error}");
    Ok((toml::to_string(scenario).map_err(wrong)?, toml::Table::try_from(scenario).map_err(wrong)?))
}
