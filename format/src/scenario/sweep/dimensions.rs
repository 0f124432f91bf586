//! The dimensions of a `[sweep]`: which keys advance together, and through which values.

use std::collections::HashSet;

use super::axis;
use super::grid::{Dimension, Key};
use super::random::{self, SOBOL_KEYS, SOBOL_SAMPLES};
use crate::scenario::findings::Findings;
use crate::scenario::format::random::{RandomSpec, Sampling};
use crate::scenario::format::sweep::{Axis, SweepSpec};
use crate::scenario::key_path::KeyPath;
use crate::text::diagnostic::Diagnostic;
use crate::text::source::{Sources, Span};
use crate::text::toml_tree::{Entry, Node, Value};

/// Greatest number of swept keys; each is compared with all others.
const MAX_KEYS: usize = 1000;

/// One dimension before its values are generated.
pub struct Group<'a> {
    keys: Vec<Swept<'a>>,
    /// The entry of `[sweep]` with its keys: a table for `random`, an array of tables for `list`.
    part: &'a Entry,
}

/// A swept key as written in the file.
pub struct Swept<'a> {
    pub path: KeyPath,
    pub entry: &'a Entry,
    source: ValueSource<'a>,
}

/// The origin of the values of a swept key.
enum ValueSource<'a> {
    /// An override: the single value in the tree.
    Fixed,
    /// `grid`, `zip`.
    Axis(&'a Axis),
    /// `list`: one value for each table that names the key.
    Tables(Vec<Option<&'a Node>>),
    /// `random`: the index among its keys.
    Drawn(&'a RandomSpec, usize),
}

/// The swept keys by dimension, in the order of the file.
pub fn groups<'a>(
    sweep: &'a Node,
    spec: &'a SweepSpec,
    fixed: &[KeyPath],
    sources: &Sources,
    findings: &mut Findings,
) -> Vec<Group<'a>> {
    let mut collector = GroupCollector { groups: Vec::new(), fixed, sources, findings };
    for part in sweep.entries() {
        let entries = part.node.entries();
        match part.key.as_str() {
            "grid" => {
                for entry in entries {
                    collector.group(part, [(entry, spec.grid.get(&entry.key).map(ValueSource::Axis))]);
                }
            }
            "zip" => {
                for (table, axes) in part.node.items().iter().zip(&spec.zip) {
                    collector.group(part, table.entries().iter().map(|e| (e, axes.get(&e.key).map(ValueSource::Axis))));
                }
            }
            "list" => collector.list(part),
            "random" => {
                if let Some(random) = &spec.random
                    && sobol_fits(random, part, collector.findings)
                {
                    let keys = entries.iter().filter(|e| RandomSpec::is_path(&e.key)).enumerate();
                    collector.group(part, keys.map(|(index, e)| (e, Some(ValueSource::Drawn(random, index)))));
                }
            }
            _ => {}
        }
    }
    collector.groups
}

/// False, with errors, when a Sobol sequence has too many samples or keys.
fn sobol_fits(random: &RandomSpec, part: &Entry, findings: &mut Findings) -> bool {
    let help = Some("`sampling = \"lhs\"` has no limit".to_owned());
    let (samples, keys) = (random.samples, random.keys.len());
    if random.sampling != Sampling::Sobol || samples <= SOBOL_SAMPLES && keys <= SOBOL_KEYS {
        return true;
    }
    if samples > SOBOL_SAMPLES {
        let span = part.node.get("samples").map_or(&part.key_span, |n| &n.span);
        let message = format!("a Sobol sequence has at most {SOBOL_SAMPLES} samples, not {samples}");
        findings.error(span.clone(), message, help.clone());
    }
    if keys > SOBOL_KEYS {
        let message = format!("a Sobol sequence has at most {SOBOL_KEYS} keys, not {keys}");
        findings.error(part.key_span.clone(), message, help);
    }
    false
}

/// Collects groups; no two keys may lead to the same value.
struct GroupCollector<'a, 'f> {
    groups: Vec<Group<'a>>,
    fixed: &'f [KeyPath],
    sources: &'f Sources,
    findings: &'f mut Findings,
}

impl<'a> GroupCollector<'a, '_> {
    fn group(&mut self, part: &'a Entry, entries: impl IntoIterator<Item = (&'a Entry, Option<ValueSource<'a>>)>) {
        let mut keys = Vec::new();
        for (entry, source) in entries {
            let Some(source) = source else { continue };
            match self.path_of(entry, &keys) {
                // An overridden key is no longer swept: its one value is in the tree.
                Ok((path, overridden)) => {
                    keys.push(Swept { path, entry, source: if overridden { ValueSource::Fixed } else { source } });
                }
                Err((span, message)) => self.findings.error(span, message, None),
            }
        }
        self.groups.push(Group { keys, part });
    }

    /// The tables of a list; keys in the order in which they are first named. Different tables may
    /// set parts of each other's values, since each run uses one table.
    fn list(&mut self, part: &'a Entry) {
        let tables = part.node.items();
        if tables.is_empty() {
            return;
        }
        let mut keys: Vec<Swept<'a>> = Vec::new();
        for (at, table) in tables.iter().enumerate() {
            let mut here: Vec<Swept<'a>> = Vec::new();
            for entry in table.entries() {
                let (path, overridden) = match self.path_of(entry, &here) {
                    Ok(found) => found,
                    Err((span, message)) => {
                        self.findings.error(span, message, None);
                        continue;
                    }
                };
                if path.segments.len() == 1 && matches!(entry.node.value, Value::Table(_)) {
                    let message = format!("`{}` would be replaced as a whole", entry.key);
                    let help = format!("a path is written as one key in quotes: \"{}.KEY\" = ...", entry.key);
                    self.findings.error(entry.key_span.clone(), message, Some(help));
                    continue;
                }
                let none =
                    || Swept { path: path.clone(), entry, source: ValueSource::Tables(vec![None; tables.len()]) };
                here.push(none());
                let known = keys.iter().position(|k| k.path.equals(&path));
                if known.is_none() && keys.len() == MAX_KEYS {
                    let message = format!("`{}` is one too many: at most {MAX_KEYS} keys are swept", entry.key);
                    self.findings.error(entry.key_span.clone(), message, None);
                    continue;
                }
                let known = known.unwrap_or_else(|| {
                    keys.push(none());
                    keys.len() - 1
                });
                match &mut keys[known].source {
                    ValueSource::Tables(values) if !overridden => values[at] = Some(&entry.node),
                    source => *source = ValueSource::Fixed,
                }
            }
        }
        self.groups.push(Group { keys, part });
    }

    /// The path of a swept key, and whether this key is overridden. `here` are keys that apply at
    /// the same time.
    fn path_of(&self, entry: &Entry, here: &[Swept]) -> Result<(KeyPath, bool), (Span, String)> {
        let refuse = |message: String| (entry.key_span.clone(), message);
        if here.len() + self.groups.iter().map(|group| group.keys.len()).sum::<usize>() >= MAX_KEYS {
            return Err(refuse(format!("`{}` is one too many: at most {MAX_KEYS} keys are swept", entry.key)));
        }
        let path = KeyPath::parse(&entry.key, &entry.key_span, self.sources).map_err(|e| (e.span, e.message))?;
        if path.segments[0].0 == "claim" {
            return Err(refuse(format!("`{}` cannot be swept: a claim is about all runs", entry.key)));
        }
        if ["sweep", "schema", "search"].contains(&path.segments[0].0.as_str()) {
            return Err(refuse(format!("`{}` cannot be swept", entry.key)));
        }
        let mut earlier = self.groups.iter().flat_map(Group::keys).chain(here);
        if let Some(other) = earlier.find(|other| other.path.overlaps(&path)) {
            let location = other.location(self.sources);
            return Err(refuse(format!("`{}` is swept already by `{}` at {location}", entry.key, other.entry.key)));
        }
        match self.fixed.iter().find(|f| f.overlaps(&path)) {
            Some(same) if same.segments.len() == path.segments.len() => Ok((path, true)),
            Some(_) => Err(refuse(format!("`{}` is swept and cannot be overridden in part", entry.key))),
            None => Ok((path, false)),
        }
    }
}

impl<'a> Group<'a> {
    /// Its keys.
    pub fn keys(&self) -> &[Swept<'a>] {
        &self.keys
    }

    /// The length of the dimension; each key that is not overridden must have this number of
    /// values.
    pub fn length(&self, sources: &Sources, findings: &mut Findings) -> usize {
        let mut counted = self.keys.iter().filter_map(|s| Some((s, s.count()?)));
        let Some((first, length)) = counted.next() else {
            // Each table without keys is a run of the file as written.
            return if self.keys.is_empty() { self.part.node.items().len().max(1) } else { 1 };
        };
        for (other, count) in counted.filter(|(_, count)| *count != length) {
            let (a, b) = (&first.entry.key, &other.entry.key);
            let message = format!("`{b}` has {count} values, but `{a}` of the same table has {length}");
            let location = first.location(sources);
            let help = format!("`{a}` is at {location}; the values of one table of `zip` advance together");
            findings.error(other.entry.key_span.clone(), message, Some(help));
        }
        length
    }

    /// Generates the values. `root` is the scenario's tree with its overrides.
    pub fn dimension(self, length: usize, root: &Node, findings: &mut Findings) -> Dimension {
        let part = self.part;
        let sampling = self.keys.iter().find_map(|swept| match swept.source {
            ValueSource::Drawn(random, _) => Some(random.sampling),
            _ => None,
        });
        let keys: Vec<Key> = self.keys.into_iter().filter_map(|swept| swept.key(root, findings)).collect();
        refuse_duplicates(&keys, length, part, findings);
        Dimension { keys, length, sampling }
    }
}

impl Swept<'_> {
    /// `file:line:column` of the key.
    fn location(&self, sources: &Sources) -> String {
        Diagnostic::error(sources, &self.entry.key_span, "", None).location()
    }

    /// The number of its values, without generating them; none when it is overridden.
    fn count(&self) -> Option<usize> {
        match &self.source {
            ValueSource::Fixed => None,
            ValueSource::Axis(axis) => Some(axis::count(axis)),
            ValueSource::Tables(values) => Some(values.len()),
            ValueSource::Drawn(random, _) => Some(random.samples as usize),
        }
    }

    /// The key with its values; `None` (with an error) when it was overridden and then overridden
    /// as a whole.
    fn key(self, root: &Node, findings: &mut Findings) -> Option<Key> {
        let Swept { path, entry, source } = self;
        let values: Vec<Option<Node>> = match source {
            ValueSource::Axis(axis) => axis::values(axis, &entry.node).into_iter().map(Some).collect(),
            ValueSource::Tables(values) => {
                axis::unify_numbers_with_gaps(values.into_iter().map(Option::<&Node>::cloned).collect())
            }
            ValueSource::Drawn(random, index) => {
                random::samples(random, seed(root), &path, index, &entry.node).into_iter().map(Some).collect()
            }
            ValueSource::Fixed => match path.get(root) {
                Some(value) => vec![Some(value.clone())],
                None => {
                    let message = format!("`{}` is swept, and overrides leave no such value", entry.key);
                    findings.error(entry.key_span.clone(), message, None);
                    return None;
                }
            },
        };
        Some(Key { name: entry.key.clone(), path, values })
    }
}

/// The scenario's seed. An invalid seed is reported when the scenario is read.
fn seed(root: &Node) -> u64 {
    match root.get("seed").map(|n| &n.value) {
        Some(Value::Integer(seed)) => *seed as u64,
        _ => crate::scenario::Scenario::default().seed,
    }
}

/// Refuses equal combinations: equal runs would have equal keys and overwrite each other's results.
fn refuse_duplicates(keys: &[Key], length: usize, part: &Entry, findings: &mut Findings) {
    let mut known = HashSet::new();
    for at in 0..length {
        let text = |k: &Key| k.value(at).map_or_else(String::new, |node| format!("{} ", node.to_toml()));
        let texts: Vec<String> = keys.iter().map(text).collect();
        if known.insert(texts.clone()) {
            continue;
        }
        let values = texts.iter().map(|t| t.trim_end()).filter(|t| !t.is_empty()).collect::<Vec<_>>().join(", ");
        if part.key == "list" {
            let table = &part.node.items()[at];
            let message = format!("table {at} of `list` gives the same values as one before it");
            // If tables differ in an overridden key only, the equal runs are reported instead.
            if keys.iter().all(|k| k.values.len() == length) {
                findings.error(table.span.clone(), message, None);
            }
        } else if let Some(varied) = keys.iter().find(|k| k.values.len() > 1) {
            // The same holds here.
            let (message, help) = match (part.key.as_str(), keys) {
                ("random", _) => {
                    let help = "fewer samples, more values to draw from, or `grid` to have each value once";
                    (format!("{values} is drawn twice, by sample {at} and an earlier one"), Some(help.to_owned()))
                }
                (_, [key]) => (format!("`{}` has the value {values} twice", key.name), None),
                _ => (format!("the combination of values {values} occurs twice"), None),
            };
            let span = varied.value(at).map_or(part.key_span.clone(), |node| node.span.clone());
            findings.error(span, message, help);
        }
    }
}
