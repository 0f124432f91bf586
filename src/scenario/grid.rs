//! The combinations of swept values, by number.

use std::collections::HashSet;

use serde::Deserialize;

use super::{
    axis,
    decode::NodeDeserializer,
    diagnostic::Findings,
    path::Path,
    source::{Sources, Span},
    spec::sweep::{Axis, SweepSpec},
    tree::{Entry, Node},
};

/// The swept keys with their values, in the order of the file.
#[derive(Default)]
pub struct Grid {
    keys: Vec<Key>,
    /// Runs per combination.
    pub repeat: u32,
}

struct Key {
    name: String,
    path: Path,
    values: Vec<Node>,
}

impl Grid {
    /// Read the sweep of a scenario's tree; `fixed` are paths whose values have been overridden. An expansion to more than
    /// `max_runs` runs is refused before its values are made.
    pub fn read(root: &Node, fixed: &[Path], sources: &Sources, max_runs: usize, findings: &mut Findings) -> Grid {
        let Some(sweep) = root.get("sweep") else { return Grid { keys: Vec::new(), repeat: 1 } };
        let spec = match SweepSpec::deserialize(NodeDeserializer(sweep)) {
            Ok(spec) => spec,
            Err(error) => {
                error.report("sweep", findings);
                return Grid::default();
            }
        };
        let mut axes: Vec<(Path, &Entry, Option<&Axis>)> = Vec::new();
        for entry in sweep.get("grid").map_or(&[][..], Node::entries) {
            match path_of(entry, &axes, fixed, sources) {
                // An overridden key is swept no more: its one value stands in the tree.
                Ok((path, true)) => axes.push((path, entry, None)),
                Ok((path, false)) => axes.push((path, entry, spec.grid.get(&entry.key))),
                Err((span, message)) => findings.error(span, message, None),
            }
        }
        let repeated_seed = axes.iter().find(|(path, ..)| path.segments[0].0 == "seed");
        if let (Some((_, entry, _)), 2..) = (repeated_seed, spec.repeat) {
            findings.error(entry.key_span.clone(), "`seed` cannot be swept together with `repeat`", None);
        }
        let counts = axes.iter().map(|(.., axis)| axis.map_or(1, axis::count));
        let runs = counts.fold(spec.repeat as usize, usize::saturating_mul);
        if runs > max_runs {
            let place = sweep.entry("grid").or(sweep.entry("repeat"));
            let span = place.map_or(sweep.span.clone(), |e| e.key_span.clone());
            let help = Some("`--max-runs` raises the limit".into());
            findings.error(span, format!("the sweep has {runs} runs, {max_runs} are allowed"), help);
            return Grid::default();
        }
        let mut keys = Vec::new();
        for (path, entry, axis) in axes {
            let values = match axis {
                Some(axis) => axis::nodes(axis, &entry.node),
                None => match path.get(root) {
                    Some(value) => vec![value.clone()],
                    // Overridden, and then overridden as a whole.
                    None => {
                        let message = format!("`{}` is swept, and overrides leave no such value", entry.key);
                        findings.error(entry.key_span.clone(), message, None);
                        continue;
                    }
                },
            };
            refuse_twins(&entry.key, &values, findings);
            keys.push(Key { name: entry.key.clone(), path, values });
        }
        Grid { keys, repeat: spec.repeat }
    }

    /// Combinations of values.
    pub fn cells(&self) -> usize {
        self.keys.iter().map(|k| k.values.len()).product()
    }

    /// Combinations times repetitions.
    pub fn runs(&self) -> usize {
        self.cells() * self.repeat as usize
    }

    /// The values of one combination, the last key changing fastest.
    pub fn cell(&self, mut number: usize) -> Vec<(Path, Node)> {
        let mut cell: Vec<_> = self
            .keys
            .iter()
            .rev()
            .map(|key| {
                let value = &key.values[number % key.values.len()];
                number /= key.values.len();
                (key.path.clone(), value.clone())
            })
            .collect();
        cell.reverse();
        cell
    }

    /// The values of a combination under the names in the file.
    pub fn parameters(&self, cell: &[(Path, Node)]) -> Vec<(String, toml::Value)> {
        self.keys.iter().zip(cell).map(|(key, (_, value))| (key.name.clone(), value.to_toml())).collect()
    }
}

/// The path of a swept key, and whether exactly it is overridden.
fn path_of(
    entry: &Entry,
    earlier: &[(Path, &Entry, Option<&Axis>)],
    fixed: &[Path],
    sources: &Sources,
) -> Result<(Path, bool), (Span, String)> {
    let refuse = |message: String| (entry.key_span.clone(), message);
    let path = Path::parse(&entry.key, &entry.key_span, sources).map_err(|e| (e.span, e.message))?;
    if ["sweep", "schema"].contains(&path.segments[0].0.as_str()) {
        return Err(refuse(format!("`{}` cannot be swept", entry.key)));
    }
    if let Some((_, other, _)) = earlier.iter().find(|(other, ..)| other.overlaps(&path)) {
        return Err(refuse(format!("`{}` is swept already by `{}`", entry.key, other.key)));
    }
    match fixed.iter().find(|f| f.overlaps(&path)) {
        Some(same) if same.segments.len() == path.segments.len() => Ok((path, true)),
        Some(_) => Err(refuse(format!("`{}` is swept and cannot be overridden in part", entry.key))),
        None => Ok((path, false)),
    }
}

/// Equal runs would have equal keys and write over each other.
fn refuse_twins(key: &str, values: &[Node], findings: &mut Findings) {
    let mut seen = HashSet::new();
    for value in values {
        let text = value.to_toml().to_string();
        if !seen.insert(text.clone()) {
            findings.error(value.span.clone(), format!("`{key}` has the value {text} twice"), None);
        }
    }
}
