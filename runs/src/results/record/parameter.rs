//! Values of swept parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The value of a swept parameter in one run. Vectors and tables are recorded as text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ParamValue {
    /// A whole number.
    Integer(i64),
    /// A real number; finite, as scenario files are.
    Number(f64),
    /// A boolean.
    Flag(bool),
    /// Any other value, as the scenario file would write it (strings without quotes).
    Text(String),
}

impl ParamValue {
    /// The value as a real number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(i) => Some(*i as f64),
            Self::Number(x) => Some(*x),
            Self::Flag(_) | Self::Text(_) => None,
        }
    }

    /// The value as text; of the path of a robot file only the file name.
    pub fn brief(&self) -> String {
        let text = self.to_string();
        let is_file = [".toml", ".urdf", ".xml", ".mjcf"].iter().any(|end| text.ends_with(end));
        text.rsplit('/').next().filter(|_| is_file).map_or(text.clone(), str::to_owned)
    }
}

/// True if the swept parameter is a truth (`expect.*`, `compare.truth.*`), which does not
/// distinguish runs.
pub fn is_truth(name: &str) -> bool {
    name.starts_with("expect.") || name.starts_with("compare.truth.")
}

/// Compares numbers by size and other values by their text; a missing value comes first.
pub(in crate::results) fn compare_values(a: Option<&ParamValue>, b: Option<&ParamValue>) -> std::cmp::Ordering {
    let number = |v: Option<&ParamValue>| v.and_then(ParamValue::number);
    match (number(a), number(b)) {
        (Some(x), Some(y)) => x.total_cmp(&y),
        _ => a.map(ToString::to_string).cmp(&b.map(ToString::to_string)),
    }
}

/// Shortest text that reads back to the same value.
impl fmt::Display for ParamValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(i) => write!(f, "{i}"),
            // `{:?}` chooses an exponent where plain digits would be long.
            Self::Number(x) => write!(f, "{x:?}"),
            Self::Flag(b) => write!(f, "{b}"),
            Self::Text(s) => f.write_str(s),
        }
    }
}

impl From<i64> for ParamValue {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<f64> for ParamValue {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<bool> for ParamValue {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<&str> for ParamValue {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}
