//! Expands a scenario file to its runs, one at a time: a sweep of millions is never in memory.

use std::{
    ops::Range,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use super::claims::{self, PlannedClaim};
use super::file::ScenarioFile;
use super::inputs::{Files, Input};
use super::reference::Reference;
use super::run::{Origin, Run};
use super::scenario::{self, Scenario};
use super::search::{self, PlannedSearch};
use super::sweep::{Cell, Grid};
use super::unused_parameters::UnusedParameters;
use super::world::{WorldNodes, Worlds};
use super::{events, overrides};
use crate::scenario::findings::Findings;
use crate::scenario::key_path::KeyPath;
use crate::text::diagnostic::{Diagnostic, Diagnostics};
use crate::text::source::{Sources, Span};
use crate::text::toml_tree::Node;

/// Number of errors after which an expansion stops.
pub(super) const MAX_ERRORS: usize = 50;

/// Combination of values, repetitions, and the number of the run of a search.
type Place = (usize, Range<u32>, Option<usize>);

/// Number of repetitions that are created in one pass over their values.
const REPETITIONS_PER_PASS: u32 = 64;

/// A file with its overrides and its sweep; creates each run by its number.
pub struct Expansion {
    file: ScenarioFile,
    /// The texts: the file, overrides, and world files once they are read.
    sources: Mutex<Sources>,
    worlds: Mutex<Worlds>,
    base: Arc<Node>,
    grid: Grid,
    claims: Vec<PlannedClaim>,
    search: Option<PlannedSearch>,
    /// Warnings about the claims.
    claim_warnings: Diagnostics,
    /// A hash of all values as written, sweep included.
    definition: [u8; 32],
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
        let claims = claims::read(&base, &grid, &fixed, &mut findings);
        if findings.has_errors() {
            findings.append(scenario::read(&base).1);
            return Err(findings.into_diagnostics(&sources));
        }
        let search = search::read(&base, &grid, &fixed, (&sources, max_runs), &mut findings);
        if findings.has_errors() {
            findings.append(scenario::read(&base).1);
            return Err(findings.into_diagnostics(&sources));
        }
        let claim_warnings = findings.into_diagnostics(&sources);
        let definition = definition(&base);
        base.remove("sweep");
        // A claim changes no run.
        base.remove("claim");
        // A search sets one value of each run.
        base.remove("search");
        let (files, worlds) = Default::default();
        let (sources, base) = (Mutex::new(sources), Arc::new(base));
        let file = self.clone();
        Ok(Expansion { file, sources, worlds, base, grid, claims, search, claim_warnings, definition, files })
    }
}

impl Expansion {
    /// The file.
    pub fn file(&self) -> &ScenarioFile {
        &self.file
    }

    /// The texts read so far.
    pub(super) fn sources(&self) -> Sources {
        lock(&self.sources).clone()
    }

    /// Number of runs; of a search, the greatest number.
    pub fn runs(&self) -> usize {
        self.grid.runs() * self.slots()
    }

    /// Number of runs that differ in their seeds alone, and follow each other.
    pub fn repetitions(&self) -> usize {
        if self.search.is_some() { 1 } else { self.grid.repeat.max(1) as usize }
    }

    /// The search, if the file has one.
    pub fn search(&self) -> Option<&PlannedSearch> {
        self.search.as_ref()
    }

    /// Greatest number of runs of each combination of values and repetition.
    fn slots(&self) -> usize {
        self.search.as_ref().map_or(1, PlannedSearch::slots_per_cell)
    }

    /// Number of the runs that belong to one part of a batch together with this run: its own, or that
    /// of the group of cells of a search that depend on each other.
    pub fn unit(&self, number: usize) -> usize {
        self.search.as_ref().map_or(number, |search| search.group(number / self.slots()))
    }

    /// Numbers of the runs that can be checked before any result is known: all, or of a search the
    /// first two of each cell, which stand for both ends.
    pub fn checked_numbers(&self) -> impl Iterator<Item = usize> + use<> {
        let slots = self.slots();
        let is_search = self.search.is_some();
        (0..self.runs()).filter(move |number| !is_search || number % slots < 2)
    }

    fn place(&self, number: usize) -> Place {
        let (cell, repeat) = (number / self.slots(), self.grid.repeat.max(1) as usize);
        let repetition = (cell % repeat) as u32;
        (cell / repeat, repetition..repetition + 1, self.search.as_ref().map(|_| number))
    }

    /// The claims about its runs.
    pub fn claims(&self) -> &[PlannedClaim] {
        &self.claims
    }

    /// Warnings about the claims.
    pub fn claim_warnings(&self) -> &Diagnostics {
        &self.claim_warnings
    }

    /// True if the key is swept, as a whole or in part.
    pub fn sweeps(&self, key: &str) -> bool {
        let path = KeyPath::internal(key);
        self.grid.overlaps(&path) || self.search.as_ref().is_some_and(|search| search.overlaps(&path))
    }

    /// A hash of the values that define all runs: those of the file, with its sweep and overrides.
    /// The path of the robot does not count, since it may differ between machines.
    pub fn definition(&self) -> &[u8; 32] {
        &self.definition
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
        // A search gives both ends of each of its cells.
        let all: Box<dyn Iterator<Item = _>> = match self.search {
            Some(_) => Box::new(self.checked_numbers().map(|number| self.place(number))),
            None => {
                Box::new((0..self.grid.cells()).flat_map(parts).map(|(cell, repetitions)| (cell, repetitions, None)))
            }
        };
        for place in all {
            let runs = self.cell(place, Values::Written, &mut findings);
            if findings.errors() >= MAX_ERRORS {
                break;
            }
            for run in runs.map(|cell| cell.runs).unwrap_or_default() {
                unused.check(&run);
                consume(run);
            }
        }
        if findings.has_errors() { Err(findings.into_diagnostics(&self.sources())) } else { Ok(unused.warnings()) }
    }

    /// One run by its number, from 0; `None` if there is no such run or it has an error.
    pub fn run(&self, number: usize) -> Option<Run> {
        let runs = self.cell(self.place(number), Values::Written, &mut Findings::default());
        runs?.runs.pop().filter(|_| number < self.runs())
    }

    /// The run with this number, without its text and swept parameters, and whether its reference
    /// has a seed of its own. `None` after an error of any of its repetitions, which goes to
    /// `findings`.
    pub(super) fn check_cell(&self, number: usize, findings: &mut Findings) -> Option<(Run, bool)> {
        let mut cell = self.cell(self.place(number), Values::Checked, findings)?;
        Some((cell.runs.pop()?, cell.reference_has_own_seed))
    }

    /// Some repetitions of a combination of values; `None` after an error, which goes to
    /// `findings`.
    fn cell(&self, (number, repetitions, probe): Place, values: Values, findings: &mut Findings) -> Option<CellRuns> {
        let cell = self.grid.cell(number);
        let searched =
            probe.zip(self.search.as_ref()).map_or_else(Vec::new, |(probe, search)| search.parameters(probe));
        let mut swept = cell.values();
        swept.extend(searched.clone());
        let mut root = Node::clone(&self.base);
        let mut found = Findings::default();
        for (path, value) in &swept {
            if let Err(error) = path.set(&mut root, value.clone()) {
                found.error(error.span, error.message, None);
            }
        }
        let world = {
            let mut sources = lock(&self.sources);
            let has_floor = root.get("floor").is_some();
            let world = lock(&self.worlds).expand(&mut root, &self.file.path, &mut sources, &mut found);
            world.iter().filter(|_| has_floor).for_each(|world| world.note_unused_floor(&mut found));
            world
        };
        let sources = &self.sources();
        let (scenario, read) = scenario::read(&root);
        found.append(read);
        found.explain(|span| replaced_position(span, &swept, &self.base, sources));
        let mut warnings = findings.append(found).into_diagnostics(sources);
        let mut reference = Reference::read(&root, sources, findings);
        let reference_warnings = reference.as_mut().map(|r| std::mem::take(&mut r.warnings)).unwrap_or_default();
        warnings.0.extend(reference_warnings.into_diagnostics(sources).0);
        let scenario = scenario?;
        let (inputs, reference_inputs) = {
            let mut files = lock(&self.files);
            let mut read = |scenario: &Scenario| files.read(scenario, &self.file.path, &root, findings);
            (read(&scenario), reference.as_ref().map(|r| read(&r.scenario)).unwrap_or_default())
        };
        let parts = CellParts { expansion: self, sources, root: &root, world: &world, swept: &swept, values };
        let mut runs = Vec::new();
        for repetition in repetitions {
            let index = probe.unwrap_or(number * self.grid.repeat as usize + repetition as usize);
            let later = u64::from(self.grid.repeat.saturating_sub(repetition + 1));
            let seeded =
                |scenario: &Scenario, by: u32| Scenario { seed: scenario.seed + u64::from(by), ..scenario.clone() };
            let reference = match &reference {
                Some(reference) => {
                    let (by, later) = if reference.has_own_seed() { (0, 0) } else { (repetition, later) };
                    let scenario = seeded(&reference.scenario, by);
                    let run = parts.run(index, scenario, later, &reference_inputs, &reference.values, findings)?;
                    Some(Box::new(run))
                }
                None => None,
            };
            let run = parts.run(index, seeded(&scenario, repetition), later, &inputs, &[], findings)?;
            let mut parameters = Vec::new();
            if values == Values::Written {
                // The run has its text, so its table can be written too.
                let table = || run.scenario.to_table().unwrap_or_default();
                parameters = Cell::parameters(&cell, &root, &table);
                let axes = self.search.iter().flat_map(|search| &search.axes);
                parameters.extend(axes.zip(&searched).map(|(axis, (_, node))| (axis.name.clone(), node.to_toml())));
            }
            let warnings = std::mem::take(&mut warnings);
            runs.push(Run { parameters, warnings, reference, ..run });
        }
        Some(CellRuns { runs, reference_has_own_seed: reference.is_some_and(|r| r.has_own_seed()) })
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Some runs of a cell.
struct CellRuns {
    runs: Vec<Run>,
    reference_has_own_seed: bool,
}

/// Data that all runs of a cell share.
struct CellParts<'a> {
    expansion: &'a Expansion,
    sources: &'a Sources,
    world: &'a Option<Arc<WorldNodes>>,
    root: &'a Node,
    swept: &'a [(KeyPath, Node)],
    values: Values,
}

/// Whether the values of a run are written out.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Values {
    /// As TOML.
    Written,
    /// Only checked that they can be, for all repetitions.
    Checked,
}

impl CellParts<'_> {
    /// A run; `later` repetitions with greater seeds follow it.
    fn run(
        &self,
        index: usize,
        scenario: Scenario,
        later: u64,
        inputs: &[Input],
        values: &[(KeyPath, Node)],
        findings: &mut Findings,
    ) -> Option<Run> {
        let Expansion { file, base, .. } = self.expansion;
        let written = match self.values {
            Values::Written => resolved(&scenario),
            Values::Checked => check_seed(scenario.seed.saturating_add(later)).map(|()| String::new()),
        };
        match written {
            Ok(resolved_toml) => {
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
                        sources: self.sources.clone(),
                        base: base.clone(),
                        swept: self.swept.to_vec(),
                        world: self.world.clone(),
                        added: values.to_vec(),
                        reported: Arc::default(),
                    },
                };
                // With errors among the findings the run is dropped.
                run.events = events::read(&run, self.sources, findings).unwrap_or_default();
                Some(run)
            }
            Err(error) => {
                findings.error(KeyPath::internal("seed").locate(self.root).1, error.to_string(), None);
                None
            }
        }
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

/// Refuses a seed that TOML cannot hold; names the first of its repetitions.
fn check_seed(seed: u64) -> Result<(), ResolveError> {
    match i64::try_from(seed) {
        Ok(_) => Ok(()),
        Err(_) => Err(ResolveError::Seed(i64::MAX as u64 + 1)),
    }
}

/// A hash of a tree of values, without the robot's path.
fn definition(root: &Node) -> [u8; 32] {
    let mut tree = root.clone();
    if let Some(robot) = tree.get_mut("robot") {
        robot.remove("model");
    }
    let mut hasher = blake3::Hasher::new();
    tree.hash_parts(&mut |bytes| {
        hasher.update(bytes);
    });
    *hasher.finalize().as_bytes()
}

/// The scenario with every value written out.
fn resolved(scenario: &Scenario) -> Result<String, ResolveError> {
    check_seed(scenario.seed)?;
    Ok(scenario.to_toml()?)
}
