//! The format of fit files.

use std::collections::BTreeMap;
use std::fmt;

use schemars::JsonSchema;
use serde::de::{self, Deserialize, Deserializer, SeqAccess, Visitor};

use crate::text::quantity::{count, json, some_positive};

/// A fit: parameters of a scenario from recorded data.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitSpec {
    /// Text for the report.
    #[serde(default)]
    pub description: String,
    /// The scenario that is compared with the data, relative to this file. It must be one run.
    pub scenario: String,
    /// Confidence of the intervals.
    #[serde(default = "default_confidence", deserialize_with = "open_fraction")]
    #[schemars(with = "json::Fraction")]
    pub confidence: f64,
    /// Probability of rejecting a fit or a data set that agrees with its noise.
    #[serde(default = "default_significance", deserialize_with = "open_fraction")]
    #[schemars(with = "json::Fraction")]
    pub significance: f64,
    /// Greatest ratio of the residuals of held-out data to those of fitted data, root mean squares over the
    /// noise. Left out: tested at `significance`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub hold_out_ratio: Option<f64>,
    /// Greatest number of iterations.
    #[serde(default = "default_iterations", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub max_iterations: u32,
    /// Recorded data.
    pub data: Vec<DataSpec>,
    /// Parameters to find.
    pub parameter: Vec<ParameterSpec>,
    /// Signals to compare.
    pub signal: Vec<SignalSpec>,
}

/// Data of one experiment.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DataSpec {
    /// Name in messages and in `data` of signals. Left out: the file's, without its ending.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// A log (`.mcap`) or a table (`.csv`), relative to this file.
    pub file: String,
    /// Values of the scenario for this experiment, by dotted key in quotes, as in `--set`.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, toml::Value>,
    /// Check the fitted parameters on these data instead of fitting to them.
    #[serde(default)]
    pub hold_out: bool,
    /// First instant of the data that counts, s. Left out: the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Last instant of the data that counts, s. Left out: the last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Simulated time at time 0 of the data, s.
    #[serde(default)]
    pub offset: f64,
    /// Column of the time in a table, s.
    #[serde(default = "default_time")]
    pub time: String,
    /// Columns of a table that have other names than those of `runner export`: name of `export` =
    /// name in the table.
    #[serde(default)]
    pub columns: BTreeMap<String, String>,
}

/// A parameter to find.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// Dotted key of a number of the scenario, as in `--set`, or several keys with the same value.
    pub key: Keys,
    /// First estimate.
    pub start: f64,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Scale on which steps are taken and the interval is symmetric.
    #[serde(default)]
    pub scale: Scale,
    /// Step of the differences: a part of the value. Left out: the cube root of the integrator's relative
    /// tolerance.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub step: Option<f64>,
    /// Unit, where the program does not know it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

/// One key or several.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub enum Keys {
    /// One key.
    One(String),
    /// Keys with the same value.
    Several(Vec<String>),
}

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct KeysVisitor;
        impl<'de> Visitor<'de> for KeysVisitor {
            type Value = Keys;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a key or an array of keys")
            }

            fn visit_str<E: de::Error>(self, key: &str) -> Result<Keys, E> {
                Ok(Keys::One(key.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Keys, A::Error> {
                let mut keys = Vec::new();
                while let Some(key) = items.next_element()? {
                    keys.push(key);
                }
                Ok(Keys::Several(keys))
            }
        }
        d.deserialize_any(KeysVisitor)
    }
}

impl Keys {
    /// The keys.
    pub fn all(&self) -> &[String] {
        match self {
            Keys::One(key) => std::slice::from_ref(key),
            Keys::Several(keys) => keys,
        }
    }

    /// The first key, with the number of further ones.
    pub fn name(&self) -> String {
        match self.all() {
            [key] => key.clone(),
            [key, rest @ ..] => format!("{key} (and {} more)", rest.len()),
            [] => String::new(),
        }
    }
}

/// A scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The value.
    #[default]
    Linear,
    /// Its logarithm; needs `min` above 0.
    Log,
}

/// Signals with the same noise.
#[derive(Clone, Debug, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SignalSpec {
    /// Column of `runner export`, in which `*` matches any characters and `?` one.
    pub column: String,
    /// Standard deviation of the noise, in the column's unit. Left out of all signals: estimated.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub sigma: Option<f64>,
    /// Names of the data that have it. Left out: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<Vec<String>>,
}

fn default_confidence() -> f64 {
    0.95
}

fn default_significance() -> f64 {
    0.001
}

fn default_iterations() -> u32 {
    50
}

fn default_time() -> String {
    "time_s".to_owned()
}

/// Between 0 and 1, both excluded.
fn open_fraction<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let value = f64::deserialize(d)?;
    match value > 0.0 && value < 1.0 {
        true => Ok(value),
        false => Err(de::Error::custom(format!("must be between 0 and 1, not {value}"))),
    }
}

/// JSON Schema (draft 2020-12) of a fit file, generated from the types that read it.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(FitSpec).to_value()
}
