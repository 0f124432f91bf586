//! The combinations of swept values, by number.

use std::cell::LazyCell;

use serde::Deserialize;

use super::dimensions::{self, Group};
use crate::scenario::decode::NodeDeserializer;
use crate::scenario::findings::Findings;
use crate::scenario::format::random::Sampling;
use crate::scenario::format::sweep::SweepSpec;
use crate::scenario::key_path::KeyPath;
use crate::text::source::{Sources, Span};
use crate::text::toml_tree::Node;

/// Greatest number of runs of any batch: run numbers have 32 bits, and one of them means none.
pub const MAX_BATCH_RUNS: usize = u32::MAX as usize;

/// The swept values: dimensions nested in the order of the file, the last changing fastest.
#[derive(Default)]
pub struct Grid {
    dimensions: Vec<Dimension>,
    /// Runs per combination.
    pub repeat: u32,
}

/// Keys that advance together: one key of `grid`, those of one table of `zip`, those of `list` or
/// those of `random`.
pub struct Dimension {
    pub keys: Vec<Key>,
    pub length: usize,
    /// How the values were drawn; none unless they are samples of `random`.
    pub sampling: Option<Sampling>,
}

/// A swept key with one value per index of its dimension; an overridden key has one value. None
/// where a table of `list` does not name the key.
pub struct Key {
    pub name: String,
    pub path: KeyPath,
    pub values: Vec<Option<Node>>,
}

/// One combination.
pub struct Cell<'a> {
    /// The swept keys in the order of the file; no value where the file's own applies.
    keys: Vec<(&'a Key, Option<&'a Node>)>,
}

impl Grid {
    /// Reads the sweep of a scenario's tree; `fixed` are the overridden paths. An expansion to more
    /// than `max_runs` runs is refused before its values are generated.
    pub fn read(root: &Node, fixed: &[KeyPath], sources: &Sources, max_runs: usize, findings: &mut Findings) -> Grid {
        let Some(sweep) = root.get("sweep") else { return Grid { dimensions: Vec::new(), repeat: 1 } };
        let spec = match SweepSpec::deserialize(NodeDeserializer(sweep)) {
            Ok(spec) => spec,
            Err(error) => {
                error.report("sweep", findings);
                return Grid::default();
            }
        };
        let groups = dimensions::groups(sweep, &spec, fixed, sources, findings);
        let lengths: Vec<usize> = groups.iter().map(|group| group.length(sources, findings)).collect();
        let repeated_seed = groups.iter().flat_map(Group::keys).find(|s| s.path.segments[0].0 == "seed");
        if let (Some(seed), 2..) = (repeated_seed, spec.repeat) {
            findings.error(seed.entry.key_span.clone(), "`seed` cannot be swept together with `repeat`", None);
        }
        let runs = lengths.iter().copied().fold(spec.repeat as usize, usize::saturating_mul);
        if runs > max_runs {
            let help = match max_runs < MAX_BATCH_RUNS {
                true => "`--max-runs` raises the limit",
                false => "no batch can have more: each run has a number of 32 bits",
            };
            let help = Some(help.into());
            findings.error(first_key_span(sweep), format!("the sweep has {runs} runs, {max_runs} are allowed"), help);
            return Grid::default();
        }
        let groups = groups.into_iter().zip(lengths);
        let dimensions = groups.map(|(group, length)| group.dimension(length, root, findings)).collect();
        Grid { dimensions, repeat: spec.repeat }
    }

    /// Number of combinations of values.
    pub fn cells(&self) -> usize {
        self.dimensions.iter().map(|d| d.length).product()
    }

    /// Number of combinations times repetitions.
    pub fn runs(&self) -> usize {
        self.cells() * self.repeat as usize
    }

    /// True if a swept key is, contains or is part of the value at this path.
    pub fn overlaps(&self, path: &KeyPath) -> bool {
        self.dimensions.iter().flat_map(|dimension| &dimension.keys).any(|key| key.path.overlaps(path))
    }

    /// The dimensions in the order of the file, each with the distance of the numbers of runs that
    /// are neighbours in it.
    pub fn strided(&self) -> Vec<(usize, &Dimension)> {
        let mut stride = self.repeat as usize;
        let mut all = Vec::new();
        for dimension in self.dimensions.iter().rev() {
            all.push((stride, dimension));
            stride *= dimension.length;
        }
        all.reverse();
        all
    }

    /// One combination, the last dimension changing fastest.
    pub fn cell(&self, mut number: usize) -> Cell<'_> {
        let mut keys = Vec::new();
        for dimension in self.dimensions.iter().rev() {
            let at = number % dimension.length;
            number /= dimension.length;
            keys.extend(dimension.keys.iter().rev().map(|key| (key, key.value(at))));
        }
        keys.reverse();
        Cell { keys }
    }
}

/// The span at which a sweep that is too large is reported: its first key that multiplies runs.
fn first_key_span(sweep: &Node) -> Span {
    let parts = || sweep.entries().iter().filter(|e| e.key != "repeat");
    parts().next().or(sweep.entry("repeat")).map_or(sweep.span.clone(), |e| e.key_span.clone())
}

impl Key {
    /// The value at an index of the dimension.
    pub fn value(&self, at: usize) -> Option<&Node> {
        self.values[at % self.values.len()].as_ref()
    }
}

impl Cell<'_> {
    /// The swept values of the scenario, in the order of the file.
    pub fn values(&self) -> Vec<(KeyPath, Node)> {
        self.keys.iter().filter_map(|(key, value)| Some((key.path.clone(), (*value)?.clone()))).collect()
    }

    /// The values under the names in the file. A key without a value in this cell has that of the
    /// run's tree, or the default in `resolved`; none if that is a table.
    pub fn parameters(&self, root: &Node, resolved: &dyn Fn() -> toml::Table) -> Vec<(String, toml::Value)> {
        let resolved = LazyCell::new(resolved);
        let fallback = |path: &KeyPath| match path.get(root) {
            Some(node) => Some(node.to_toml()),
            None => path.look_up(&resolved).filter(|value| !value.is_table()).cloned(),
        };
        let value = |key: &Key, value: &Option<&Node>| value.map(Node::to_toml).or_else(|| fallback(&key.path));
        self.keys.iter().filter_map(|(key, given)| Some((key.name.clone(), value(key, given)?))).collect()
    }
}
