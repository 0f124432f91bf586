//! Decodes the search of a file and checks it against its sweep.

use serde::Deserialize;
use std::sync::OnceLock;

use super::planned::{PlannedSearch, SearchAxis};
use crate::scenario::checks::check_search;
use crate::scenario::decode::NodeDeserializer;
use crate::scenario::findings::Findings;
use crate::scenario::format::search::{SearchSpec, SearchedKey};
use crate::scenario::key_path::KeyPath;
use crate::scenario::sweep::Grid;
use crate::text::source::Sources;
use crate::text::suggest;
use crate::text::toml_tree::{Entry, Node, Value};

/// Top-level keys that a search cannot change: they are about all runs, or name the format.
const NOT_SEARCHED: [&str; 5] = ["schema", "sweep", "claim", "search", "compare"];

/// Finest tolerance, as a fraction of the greater end: values have 14 digits.
const FINEST: f64 = 1e-12;

/// Reads the search of a scenario's tree; `fixed` are the overridden paths. None after an error.
pub fn read(
    root: &Node,
    grid: &Grid,
    fixed: &[KeyPath],
    (sources, max_runs): (&Sources, usize),
    findings: &mut Findings,
) -> Option<PlannedSearch> {
    let node = root.get("search")?;
    let spec = match SearchSpec::deserialize(NodeDeserializer(node)) {
        Ok(spec) => spec,
        Err(error) => {
            error.at(&node.span).report("search", findings);
            return None;
        }
    };
    if !check_search(&spec, root, findings) {
        return None;
    }
    let mut reader = SearchReader { root, grid, fixed, sources, findings };
    let squares = (spec.over.len() == 2 && spec.boundary.is_some()).then(|| spec.squares());
    // All keys, so that all errors are reported.
    let axes: Vec<Option<SearchAxis>> =
        node.get("over").map_or(&[][..], Node::entries).iter().map(|entry| reader.axis(entry, squares)).collect();
    let followed = reader.followed(&spec)?;
    let axes: Vec<SearchAxis> = axes.into_iter().collect::<Option<_>>()?;
    if reader.overlap(&axes) {
        return None;
    }
    let mut dimensions: Vec<(usize, usize, bool)> =
        grid.strided().iter().map(|(stride, d)| (*stride, d.length, followed.contains(stride))).collect();
    dimensions.push((1, grid.repeat.max(1) as usize, false));
    let start = axes.iter().map(|axis| axis.nearest(axis.path.get(root).and_then(number))).collect();
    let mut search = PlannedSearch { spec, axes, start, dimensions, slots: Vec::new() };
    let runs = grid.runs().saturating_mul(search.slots_per_cell());
    if runs > max_runs {
        let each = search.slots_per_cell();
        let message =
            format!("the search has up to {runs} runs, {each} for each of {}, {max_runs} are allowed", grid.runs());
        reader.error("search", message, Some("`--max-runs` raises the limit".to_owned()));
        return None;
    }
    search.slots = (0..runs).map(|_| OnceLock::new()).collect();
    Some(search)
}

/// The value of a number.
fn number(node: &Node) -> Option<f64> {
    match node.value {
        Value::Integer(x) => Some(x as f64),
        Value::Float(x) => Some(x),
        _ => None,
    }
}

/// Checks a search against the sweep.
struct SearchReader<'a, 'f> {
    root: &'a Node,
    grid: &'a Grid,
    fixed: &'a [KeyPath],
    sources: &'a Sources,
    findings: &'f mut Findings,
}

impl SearchReader<'_, '_> {
    /// A searched key: a number in the file, neither swept nor overridden.
    fn axis(&mut self, entry: &Entry, squares: Option<u64>) -> Option<SearchAxis> {
        let name = &entry.key;
        let path = match KeyPath::parse(name, &entry.key_span, self.sources) {
            Ok(path) => path,
            Err(error) => {
                self.findings.error(error.span, format!("`search.over`: {}", error.message), None);
                return None;
            }
        };
        let refused = if NOT_SEARCHED.contains(&path.segments[0].0.as_str()) {
            format!("`search.over` names `{name}`, which cannot be searched")
        } else if self.grid.overlaps(&path) {
            format!("`search.over` names `{name}`, which is swept: a key is either swept or searched")
        } else if self.fixed.iter().any(|fixed| fixed.overlaps(&path)) {
            format!("`search.over` names `{name}`, which an override sets")
        } else if let Some(node) = path.get(self.root)
            && number(node).is_none()
        {
            format!("`search.over` names `{name}`, which is {}, not a number", node.value)
        } else {
            return self.ends(entry, path, squares);
        };
        self.findings.error(entry.key_span.clone(), refused, None);
        None
    }

    /// The ends of a searched key and its tolerance.
    fn ends(&mut self, Entry { key, node, .. }: &Entry, path: KeyPath, squares: Option<u64>) -> Option<SearchAxis> {
        let spec = SearchedKey::deserialize(NodeDeserializer(node)).ok()?;
        let SearchedKey { between: [from, to], tolerance, logarithmic } = spec;
        let (ends, step) = (node.get("between")?, node.get("tolerance")?);
        let wrong = |key: &str| format!("`{key}` of `search.over` ");
        if !(from.is_finite() && to.is_finite() && from < to) {
            let message = format!("{}must be two numbers in ascending order, not {from} and {to}", wrong("between"));
            self.findings.error(ends.span.clone(), message, None);
            return None;
        }
        if logarithmic && from <= 0.0 {
            let message = format!("{}must be positive with `logarithmic`, not {from}", wrong("between"));
            self.findings.error(ends.span.clone(), message, None);
            return None;
        }
        let (range, what) = match logarithmic {
            true => (to / from - 1.0, "the ratio of `between` less 1"),
            false => (to - from, "the range of `between`"),
        };
        let finest = if logarithmic { FINEST } else { FINEST * from.abs().max(to.abs()) };
        let must = if !(tolerance > 0.0 && tolerance < range) {
            format!("must be greater than 0 and less than {what}, {range}, not {tolerance}")
        } else if tolerance < finest {
            format!("must be at least {finest:e}, 1e-12 of `between`, not {tolerance:e}")
        } else {
            let steps = SearchAxis::steps_for(&spec, squares);
            let is_whole = |node: &Node| matches!(node.value, Value::Integer(x) if x.abs() < 1 << 53);
            let whole = !logarithmic && ends.items().iter().all(is_whole) && range % steps as f64 == 0.0;
            let (name, between, span) = (key.clone(), [from, to], ends.span.clone());
            return Some(SearchAxis { name, between, logarithmic, path, steps, whole, span });
        };
        self.findings.error(step.span.clone(), wrong("tolerance") + &must, None);
        None
    }

    /// Reports a searched key that is a part of another one; true if there is one.
    fn overlap(&mut self, axes: &[SearchAxis]) -> bool {
        for (i, axis) in axes.iter().enumerate() {
            if let Some(other) = axes[..i].iter().find(|other| other.path.overlaps(&axis.path)) {
                let message = format!("names both `{}` and `{}`, which overlap", other.name, axis.name);
                self.error("search.over", format!("`search.over` {message}"), None);
                return true;
            }
        }
        false
    }

    /// The distances of neighbours in the followed dimensions.
    fn followed(&mut self, spec: &SearchSpec) -> Option<Vec<usize>> {
        let strided = self.grid.strided();
        let before = self.findings.errors();
        let mut followed = Vec::new();
        for (i, name) in spec.follow.iter().enumerate() {
            let (at, path) = (format!("search.follow.{i}"), KeyPath::internal(name));
            let names = || strided.iter().flat_map(|(_, dimension)| &dimension.keys).map(|key| key.name.as_str());
            match strided.iter().find(|(_, dimension)| dimension.keys.iter().any(|key| key.path.equals(&path))) {
                Some((stride, _)) if followed.contains(stride) => {
                    self.error(&at, format!("`{at}` names `{name}`, whose dimension is followed already"), None);
                }
                Some((stride, _)) => followed.push(*stride),
                None => {
                    let help = match names().next() {
                        Some(_) => suggest::help(name, names()),
                        None => "the file has no `[sweep]` with keys".to_owned(),
                    };
                    self.error(&at, format!("`{at}` names `{name}`, which is not swept"), Some(help));
                }
            }
        }
        (self.findings.errors() == before).then_some(followed)
    }

    fn error(&mut self, at: &str, message: String, help: Option<String>) {
        let span = KeyPath::internal(at).locate(self.root).1;
        self.findings.error(span, message, help);
    }
}
