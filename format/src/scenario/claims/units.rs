//! The units of a claim: runs, or pairs of runs, by the numbers of the runs in the sweep.

use std::collections::BTreeMap;

use crate::scenario::format::claim::{ClaimSpec, value_text};
use crate::scenario::key_path::KeyPath;
use crate::scenario::scenario::Scenario;
use crate::scenario::sweep::{Dimension, Grid, Key};
use crate::text::toml_tree::Node;

/// A claim with the structure of its units.
#[derive(Clone, Debug)]
pub struct PlannedClaim {
    /// The claim.
    pub spec: ClaimSpec,
    /// Labels of the groups that are judged alone, such as `floor.friction=0.5`; one empty label
    /// without `per`.
    pub groups: Vec<String>,
    parts: Vec<GroupPart>,
    pair: Option<Pair>,
}

/// The position of a run in a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClaimPlace {
    /// Index of the group.
    pub group: usize,
    /// Number that the two runs of a pair share, and no other run of the claim has.
    pub unit: usize,
    /// 0, or 1 for the second run of a pair.
    pub side: usize,
}

/// A key of `per`.
#[derive(Clone, Debug)]
struct GroupPart {
    stride: usize,
    length: usize,
    /// Number of the distinct value at each index of the key's dimension.
    values: Vec<usize>,
    distinct: usize,
}

/// The dimension of `between`, with the indices of its two values.
#[derive(Clone, Debug)]
struct Pair {
    stride: usize,
    length: usize,
    sides: [usize; 2],
}

/// A swept key with its dimension.
#[derive(Clone, Copy)]
pub(super) struct SweptKey<'a> {
    pub stride: usize,
    pub dimension: &'a Dimension,
    pub key: &'a Key,
}

impl<'a> SweptKey<'a> {
    /// The swept key of this name.
    pub fn find(grid: &'a Grid, name: &str) -> Option<Self> {
        let path = KeyPath::internal(name);
        let all = grid
            .strided()
            .into_iter()
            .flat_map(|(stride, dimension)| dimension.keys.iter().map(move |key| SweptKey { stride, dimension, key }));
        all.into_iter().find(|swept| swept.key.path.equals(&path))
    }

    /// Its value at an index of its dimension: where a table of `list` does not name it, that of the
    /// file or the default.
    pub fn value(&self, at: usize, base: &Node) -> Option<toml::Value> {
        let given = self.key.value(at).or_else(|| self.key.path.get(base)).map(Node::to_toml);
        given.or_else(|| {
            let defaults = Scenario::default().to_table().ok()?;
            self.key.path.look_up(&defaults).cloned()
        })
    }

    /// Indices at which it has this value.
    pub fn indices(&self, value: &toml::Value, base: &Node) -> Vec<usize> {
        let number = |v: &toml::Value| v.as_float().or(v.as_integer().map(|i| i as f64));
        let same = |other: toml::Value| match (number(value), number(&other)) {
            (Some(a), Some(b)) => a == b,
            _ => other == *value,
        };
        (0..self.dimension.length).filter(|at| self.value(*at, base).is_some_and(same)).collect()
    }
}

impl PlannedClaim {
    /// A claim about all runs of a sweep, grouped by the keys of `per`; `pair` are the key of
    /// `between` and the indices of its two values.
    pub(super) fn new(spec: ClaimSpec, per: &[SweptKey], pair: Option<(SweptKey, [usize; 2])>, base: &Node) -> Self {
        let mut groups = vec![String::new()];
        let mut parts = Vec::new();
        for swept in per {
            let mut known: BTreeMap<String, usize> = BTreeMap::new();
            let mut labels: Vec<String> = Vec::new();
            let values = (0..swept.dimension.length).map(|at| {
                let text = swept.value(at, base).map_or_else(|| "unset".to_owned(), |value| value_text(&value));
                *known.entry(text).or_insert_with_key(|text| {
                    labels.push(format!("{}={text}", swept.key.name));
                    labels.len() - 1
                })
            });
            let values: Vec<usize> = values.collect();
            let joined = |above: &String, own: &String| format!("{above} {own}").trim_start().to_owned();
            groups = groups.iter().flat_map(|above| labels.iter().map(move |own| joined(above, own))).collect();
            let (stride, length, distinct) = (swept.stride, swept.dimension.length, labels.len());
            parts.push(GroupPart { stride, length, values, distinct });
        }
        let pair = pair.map(|(swept, sides)| Pair { stride: swept.stride, length: swept.dimension.length, sides });
        PlannedClaim { spec, groups, parts, pair }
    }

    /// The position of the run with this number, from 0; none if the claim is not about it, and if
    /// the batch does not judge it.
    pub fn place(&self, number: usize) -> Option<ClaimPlace> {
        if self.spec.change.is_some() { None } else { self.any_place(number) }
    }

    /// Like [`PlannedClaim::place`], also for a claim about changes.
    pub(super) fn any_place(&self, number: usize) -> Option<ClaimPlace> {
        let group = self
            .parts
            .iter()
            .fold(0, |above, part| above * part.distinct + part.values[number / part.stride % part.length]);
        let Some(pair) = &self.pair else { return Some(ClaimPlace { group, unit: number, side: 0 }) };
        let index = number / pair.stride % pair.length;
        let side = pair.sides.iter().position(|side| *side == index)?;
        Some(ClaimPlace { group, unit: number - index * pair.stride, side })
    }

    /// True if a unit is a pair of runs.
    pub fn is_paired(&self) -> bool {
        self.pair.is_some()
    }
}
