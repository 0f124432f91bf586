//! `[sweep]`: many runs from one file.

use std::{collections::BTreeMap, fmt};

use schemars::JsonSchema;
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, MapAccess, SeqAccess, Visitor},
};

use crate::scenario::format::random::RandomSpec;
use crate::text::quantity::{count, json};
use crate::text::suggest;

/// Expansion of a file to runs. Keys are dotted paths of the scenario in quotes, such as
/// `"floor.friction"` or `"force.0.force"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SweepSpec {
    /// Every combination of the values; the last key of the file changes fastest. `grid`, the
    /// tables of `zip`, `list` and `random` are nested in the order of the file.
    pub grid: BTreeMap<String, Axis>,
    /// Tables whose values advance together: the keys of a table have equally many values. Each
    /// table is one dimension.
    #[serde(deserialize_with = "tables")]
    pub zip: Vec<BTreeMap<String, Axis>>,
    /// Tables of values, used one after the other. Keys that a table does not name have the file's
    /// values.
    #[schemars(with = "Vec<BTreeMap<String, serde_json::Value>>")]
    pub list: Vec<BTreeMap<String, toml::Value>>,
    /// Random samples of one or more keys.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random: Option<RandomSpec>,
    /// Repetitions of each run, with the seeds `seed`, `seed + 1`, .... Repetitions change fastest.
    #[serde(deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub repeat: u32,
}

impl Default for SweepSpec {
    fn default() -> Self {
        SweepSpec { grid: BTreeMap::new(), zip: Vec::new(), list: Vec::new(), random: None, repeat: 1 }
    }
}

impl SweepSpec {
    /// True when the file is one run.
    pub fn is_single(&self) -> bool {
        *self == Self::default()
    }
}

/// The values of one swept key.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// `[first, last, n]`: n values at equal distances, both ends included.
    Linspace(f64, f64, #[schemars(range(min = 2))] u32),
    /// `[first, last, n]`: n values in equal ratios, both ends included; ends of one sign, not
    /// zero.
    Logspace(f64, f64, #[schemars(range(min = 2))] u32),
    /// `[first, last, step]`: from first in steps up to last, which is included when it is on the
    /// grid.
    Step(f64, f64, f64),
    /// The values themselves.
    #[serde(untagged)]
    Values(#[schemars(with = "Vec<serde_json::Value>")] Vec<toml::Value>),
}

const FORMS: [&str; 3] = ["linspace", "logspace", "step"];

struct AxisVisitor;

impl<'de> Visitor<'de> for AxisVisitor {
    type Value = Axis;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of values, or one of `{ linspace = [a, b, n] }`, `{ logspace = [a, b, n] }`, `{ step = [a, b, s] }`")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Axis, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = seq.next_element()? {
            values.push(value);
        }
        if values.is_empty() {
            return Err(A::Error::custom("must have at least one value"));
        }
        Ok(Axis::Values(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Axis, A::Error> {
        let axis = match map.next_key::<String>()?.as_deref() {
            Some("linspace") => {
                let (a, b, n) = map.next_value()?;
                Axis::Linspace(a, b, at_least_two(n)?)
            }
            Some("logspace") => {
                let (a, b, n): (f64, f64, u32) = map.next_value()?;
                if a == 0.0 || b == 0.0 || (a < 0.0) != (b < 0.0) {
                    return Err(A::Error::custom("must have ends of one sign, neither of them 0"));
                }
                Axis::Logspace(a, b, at_least_two(n)?)
            }
            Some("step") => {
                let (a, b, s): (f64, f64, f64) = map.next_value()?;
                if s == 0.0 || (b - a) * s < 0.0 {
                    return Err(A::Error::custom(format!("must have a step that leads from {a} to {b}, not {s}")));
                }
                Axis::Step(a, b, s)
            }
            Some(other) => {
                let help = suggest::nearest(other, FORMS).map_or_else(
                    || "a path is written as one key in quotes: \"contact.method\" = [...]".into(),
                    |near| format!("did you mean `{near}`?"),
                );
                return Err(A::Error::custom(format!("cannot have the key `{other}`\n{help}")));
            }
            None => return Err(A::Error::custom("must have one of the keys `linspace`, `logspace`, `step`")),
        };
        match map.next_key::<String>()? {
            None => Ok(axis),
            Some(_) => Err(A::Error::custom("must have only one of the keys `linspace`, `logspace`, `step`")),
        }
    }
}

fn tables<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<BTreeMap<String, Axis>>, D::Error> {
    let tables = Vec::<BTreeMap<String, Axis>>::deserialize(d)?;
    match tables.iter().position(BTreeMap::is_empty) {
        Some(at) => Err(D::Error::custom(format!("must have at least one key in every table; table {at} has none"))),
        None => Ok(tables),
    }
}

fn at_least_two<E: Error>(n: u32) -> Result<u32, E> {
    if n >= 2 { Ok(n) } else { Err(E::custom(format!("must have at least 2 values, not {n}"))) }
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(AxisVisitor)
    }
}
