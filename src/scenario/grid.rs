//! The combinations of swept values, by number.

use std::collections::HashSet;

use serde::Deserialize;

use super::{
    axis,
    decode::NodeDeserializer,
    diagnostic::{Diagnostic, Findings},
    path::Path,
    source::{Sources, Span},
    spec::sweep::{Axis, SweepSpec},
    tree::{Entry, Node},
};

/// The swept values: dimensions nested in the order of the file, the last changing fastest.
#[derive(Default)]
pub struct Grid {
    dimensions: Vec<Dimension>,
    /// Runs per combination.
    pub repeat: u32,
}

/// Keys that advance together: one key of `grid`, or those of one table of `zip`.
struct Dimension {
    keys: Vec<Key>,
    length: usize,
}

/// A swept key with one value per place in its dimension; an overridden one has the same throughout.
struct Key {
    name: String,
    path: Path,
    values: Vec<Node>,
}

/// A swept key as it stands in the file; no axis when it is overridden.
struct Swept<'a> {
    path: Path,
    entry: &'a Entry,
    axis: Option<&'a Axis>,
}

impl Grid {
    /// Read the sweep of a scenario's tree; `fixed` are paths whose values have been overridden. An expansion to more than
    /// `max_runs` runs is refused before its values are made.
    pub fn read(root: &Node, fixed: &[Path], sources: &Sources, max_runs: usize, findings: &mut Findings) -> Grid {
        let Some(sweep) = root.get("sweep") else { return Grid { dimensions: Vec::new(), repeat: 1 } };
        let spec = match SweepSpec::deserialize(NodeDeserializer(sweep)) {
            Ok(spec) => spec,
            Err(error) => {
                error.report("sweep", findings);
                return Grid::default();
            }
        };
        let groups = groups(sweep, &spec, fixed, sources, findings);
        let lengths: Vec<usize> = groups.iter().map(|group| length(group, sources, findings)).collect();
        let repeated_seed = groups.iter().flatten().find(|s| s.path.segments[0].0 == "seed");
        if let (Some(seed), 2..) = (repeated_seed, spec.repeat) {
            findings.error(seed.entry.key_span.clone(), "`seed` cannot be swept together with `repeat`", None);
        }
        let runs = lengths.iter().copied().fold(spec.repeat as usize, usize::saturating_mul);
        if runs > max_runs {
            let place = sweep.entry("grid").or(sweep.entry("zip")).or(sweep.entry("repeat"));
            let span = place.map_or(sweep.span.clone(), |e| e.key_span.clone());
            let help = Some("`--max-runs` raises the limit".into());
            findings.error(span, format!("the sweep has {runs} runs, {max_runs} are allowed"), help);
            return Grid::default();
        }
        let mut dimensions = Vec::new();
        for (group, length) in groups.into_iter().zip(lengths) {
            let keys: Vec<Key> = group.into_iter().filter_map(|swept| key(swept, root, findings)).collect();
            refuse_twins(&keys, findings);
            dimensions.push(Dimension { keys, length });
        }
        Grid { dimensions, repeat: spec.repeat }
    }

    /// Combinations of values.
    pub fn cells(&self) -> usize {
        self.dimensions.iter().map(|d| d.length).product()
    }

    /// Combinations times repetitions.
    pub fn runs(&self) -> usize {
        self.cells() * self.repeat as usize
    }

    /// The values of one combination in the order of the file, the last dimension changing fastest.
    pub fn cell(&self, mut number: usize) -> Vec<(Path, Node)> {
        let mut cell = Vec::new();
        for dimension in self.dimensions.iter().rev() {
            let at = number % dimension.length;
            number /= dimension.length;
            cell.extend(dimension.keys.iter().rev().map(|key| (key.path.clone(), key.value(at).clone())));
        }
        cell.reverse();
        cell
    }

    /// The values of a combination under the names in the file.
    pub fn parameters(&self, cell: &[(Path, Node)]) -> Vec<(String, toml::Value)> {
        let keys = self.dimensions.iter().flat_map(|d| &d.keys);
        keys.zip(cell).map(|(key, (_, value))| (key.name.clone(), value.to_toml())).collect()
    }
}

impl Key {
    fn value(&self, at: usize) -> &Node {
        &self.values[at % self.values.len()]
    }
}

/// The swept keys by dimension: `grid` and `zip` in the order of the file, and within them as well.
fn groups<'a>(
    sweep: &'a Node,
    spec: &'a SweepSpec,
    fixed: &[Path],
    sources: &Sources,
    findings: &mut Findings,
) -> Vec<Vec<Swept<'a>>> {
    let mut groups: Vec<Vec<Swept>> = Vec::new();
    for part in sweep.entries() {
        let tables: Vec<Vec<(&Entry, Option<&Axis>)>> = match part.key.as_str() {
            "grid" => part.node.entries().iter().map(|e| vec![(e, spec.grid.get(&e.key))]).collect(),
            "zip" => {
                let tables = part.node.items().iter().zip(&spec.zip);
                tables.map(|(node, axes)| node.entries().iter().map(|e| (e, axes.get(&e.key))).collect()).collect()
            }
            _ => continue,
        };
        for table in tables {
            let mut group = Vec::new();
            for (entry, axis) in table {
                match path_of(entry, groups.iter().flatten().chain(&group), fixed, sources) {
                    // An overridden key is swept no more: its one value stands in the tree.
                    Ok((path, overridden)) => group.push(Swept { path, entry, axis: axis.filter(|_| !overridden) }),
                    Err((span, message)) => findings.error(span, message, None),
                }
            }
            groups.push(group);
        }
    }
    groups
}

/// How many places a dimension has; every key that is not overridden must have as many values.
fn length(group: &[Swept], sources: &Sources, findings: &mut Findings) -> usize {
    let mut counted = group.iter().filter_map(|s| Some((s, axis::count(s.axis?))));
    let Some((first, length)) = counted.next() else { return 1 };
    for (other, count) in counted.filter(|(_, count)| *count != length) {
        let (a, b) = (&first.entry.key, &other.entry.key);
        let message = format!("`{b}` has {count} values, but `{a}` beside it has {length}");
        let help = format!("`{a}` is at {}; the values of one table of `zip` advance together", first.place(sources));
        findings.error(other.entry.key_span.clone(), message, Some(help));
    }
    length
}

impl Swept<'_> {
    /// `file:line:column` of the key.
    fn place(&self, sources: &Sources) -> String {
        Diagnostic::error(sources, &self.entry.key_span, "", None).location()
    }
}

/// A swept key with its values; `None` (with an error) when it was overridden and then overridden as a whole.
fn key(swept: Swept, root: &Node, findings: &mut Findings) -> Option<Key> {
    let Swept { path, entry, axis } = swept;
    let values = match axis {
        Some(axis) => axis::nodes(axis, &entry.node),
        None => match path.get(root) {
            Some(value) => vec![value.clone()],
            None => {
                let message = format!("`{}` is swept, and overrides leave no such value", entry.key);
                findings.error(entry.key_span.clone(), message, None);
                return None;
            }
        },
    };
    Some(Key { name: entry.key.clone(), path, values })
}

/// The path of a swept key, and whether exactly it is overridden.
fn path_of<'a>(
    entry: &Entry,
    mut earlier: impl Iterator<Item = &'a Swept<'a>>,
    fixed: &[Path],
    sources: &Sources,
) -> Result<(Path, bool), (Span, String)> {
    let refuse = |message: String| (entry.key_span.clone(), message);
    let path = Path::parse(&entry.key, &entry.key_span, sources).map_err(|e| (e.span, e.message))?;
    if ["sweep", "schema"].contains(&path.segments[0].0.as_str()) {
        return Err(refuse(format!("`{}` cannot be swept", entry.key)));
    }
    if let Some(other) = earlier.find(|other| other.path.overlaps(&path)) {
        let message = format!("`{}` is swept already by `{}` at {}", entry.key, other.entry.key, other.place(sources));
        return Err(refuse(message));
    }
    match fixed.iter().find(|f| f.overlaps(&path)) {
        Some(same) if same.segments.len() == path.segments.len() => Ok((path, true)),
        Some(_) => Err(refuse(format!("`{}` is swept and cannot be overridden in part", entry.key))),
        None => Ok((path, false)),
    }
}

/// Equal runs would have equal keys and write over each other.
fn refuse_twins(keys: &[Key], findings: &mut Findings) {
    let mut seen = HashSet::new();
    let length = keys.iter().map(|k| k.values.len()).max().unwrap_or(0);
    for at in 0..length {
        let texts: Vec<String> = keys.iter().map(|k| k.value(at).to_toml().to_string()).collect();
        // Where an overridden key alone told places apart, the runs themselves are found to be equal.
        if !seen.insert(texts.clone())
            && let Some(varied) = keys.iter().find(|k| k.values.len() > 1)
        {
            let message = match keys {
                [key] => format!("`{}` has the value {} twice", key.name, texts[0]),
                _ => format!("the values {} stand together twice", texts.join(", ")),
            };
            findings.error(varied.value(at).span.clone(), message, None);
        }
    }
}
