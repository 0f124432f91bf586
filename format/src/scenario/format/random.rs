//! `sweep.random`: number of samples, sampling method and distributions.

use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, MapAccess, Visitor},
    ser::SerializeMap,
};

use crate::text::suggest;

/// Random samples of one or more keys: one dimension of the sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomSpec {
    /// Number of samples.
    pub samples: u32,
    /// Sampling method.
    pub sampling: Sampling,
    /// Distributions by dotted key, in the order of the file.
    pub keys: Vec<(String, Distribution)>,
}

/// Sampling method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// Independently of each other.
    #[default]
    Random,
    /// Latin hypercube: of each key, one sample in each of `samples` parts of equal probability.
    Lhs,
    /// An Owen-scrambled Sobol sequence, evenly spread over all keys together; best for a power of
    /// two of samples.
    Sobol,
}

/// Distribution of a key's values.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// `[a, b]`: uniform between them.
    Uniform(f64, f64),
    /// `[a, b]`, both above 0: uniform in the logarithm.
    LogUniform(f64, f64),
    /// `[mean, standard deviation]`.
    Normal(f64, f64),
    /// `[a, b]`: whole numbers from a to b, equally likely.
    Integer(i64, i64),
    /// One of these values, equally likely.
    Choice(#[schemars(with = "Vec<serde_json::Value>")] Vec<toml::Value>),
}

const FORMS: [&str; 5] = ["uniform", "log-uniform", "normal", "integer", "choice"];
const OPTIONS: [&str; 2] = ["samples", "sampling"];

impl RandomSpec {
    /// True when this key of the table is a path, not an option.
    pub fn is_path(key: &str) -> bool {
        !OPTIONS.contains(&key)
    }
}

/// A key of the table `random`: an option or a path.
struct RandomKey(String);

impl<'de> Deserialize<'de> for RandomKey {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let key = String::deserialize(d)?;
        match suggest::nearest(&key, OPTIONS) {
            Some(near) if near != key => Err(D::Error::unknown_field(&key, &OPTIONS)),
            _ => Ok(RandomKey(key)),
        }
    }
}

struct RandomVisitor;

impl<'de> Visitor<'de> for RandomVisitor {
    type Value = RandomSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of `samples`, `sampling` and distributions by path")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RandomSpec, A::Error> {
        let (mut samples, mut sampling, mut keys) = (None, Sampling::default(), Vec::new());
        while let Some(RandomKey(key)) = map.next_key()? {
            match key.as_str() {
                "samples" => samples = Some(map.next_value::<Count>()?.0),
                "sampling" => sampling = map.next_value()?,
                _ => keys.push((key, map.next_value()?)),
            }
        }
        if keys.is_empty() {
            let what = "must have at least one key to draw\nsuch as \"floor.friction\" = { uniform = [0.2, 1.0] }";
            return Err(A::Error::custom(what));
        }
        Ok(RandomSpec { samples: samples.ok_or_else(|| A::Error::missing_field("samples"))?, sampling, keys })
    }
}

struct Count(u32);

impl<'de> Deserialize<'de> for Count {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        crate::text::quantity::count(d).map(Count)
    }
}

impl<'de> Deserialize<'de> for RandomSpec {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_map(RandomVisitor)
    }
}

impl Serialize for RandomSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2 + self.keys.len()))?;
        map.serialize_entry("samples", &self.samples)?;
        map.serialize_entry("sampling", &self.sampling)?;
        self.keys.iter().try_for_each(|(key, distribution)| map.serialize_entry(key, distribution))?;
        map.end()
    }
}

impl JsonSchema for RandomSpec {
    fn schema_name() -> Cow<'static, str> {
        "RandomSpec".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "properties": {
                "samples": { "type": "integer", "minimum": 1, "description": "How many." },
                "sampling": generator.subschema_for::<Sampling>(),
            },
            "required": ["samples"],
            "minProperties": 2,
            "additionalProperties": generator.subschema_for::<Distribution>(),
        })
    }
}

struct DistributionVisitor;

impl<'de> Visitor<'de> for DistributionVisitor {
    type Value = Distribution;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "one of `{ uniform = [a, b] }`, `{ log-uniform = [a, b] }`, `{ normal = [mean, deviation] }`, \
             `{ integer = [a, b] }`, `{ choice = [values] }`",
        )
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Distribution, A::Error> {
        let must = |what: String| Err(A::Error::custom(format!("must have {what}")));
        let distribution = match map.next_key::<String>()?.as_deref() {
            Some("uniform") => {
                let (a, b): (f64, f64) = map.next_value()?;
                if a >= b || !(b - a).is_finite() {
                    return must(format!("ends of which the second is greater, not {a} and {b}"));
                }
                Distribution::Uniform(a, b)
            }
            Some("log-uniform") => {
                let (a, b): (f64, f64) = map.next_value()?;
                if a <= 0.0 || a >= b || !(b / a).is_finite() {
                    return must(format!("ends above 0 of which the second is greater, not {a} and {b}"));
                }
                Distribution::LogUniform(a, b)
            }
            Some("normal") => {
                let (mean, deviation): (f64, f64) = map.next_value()?;
                if deviation <= 0.0 {
                    return must(format!("a standard deviation greater than 0, not {deviation}"));
                }
                Distribution::Normal(mean, deviation)
            }
            Some("integer") => {
                let (a, b): (i64, i64) = map.next_value()?;
                // Up to 2^53 every whole number is exact in f64, with which draws are computed.
                if a >= b || b.checked_sub(a).is_none_or(|d| d >= 1 << 53) {
                    return must(format!(
                        "whole ends of which the second is greater, by less than 2^53, not {a} and {b}"
                    ));
                }
                Distribution::Integer(a, b)
            }
            Some("choice") => match map.next_value::<Vec<toml::Value>>()? {
                values if values.len() < 2 => {
                    return must(format!("at least 2 values to choose from, not {}", values.len()));
                }
                values => Distribution::Choice(values),
            },
            Some(other) => {
                let help = suggest::nearest(other, FORMS).map_or_else(
                    || "a path is written as one key in quotes: \"floor.friction\" = { uniform = [a, b] }".into(),
                    |near| format!("did you mean `{near}`?"),
                );
                return Err(A::Error::custom(format!("cannot have the key `{other}`\n{help}")));
            }
            None => return must(format!("one of the keys `{}`", FORMS.join("`, `"))),
        };
        match map.next_key::<String>()? {
            None => Ok(distribution),
            Some(_) => must(format!("only one of the keys `{}`", FORMS.join("`, `"))),
        }
    }
}

impl<'de> Deserialize<'de> for Distribution {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(DistributionVisitor)
    }
}
