//! Values of swept parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The value one run had for a swept parameter. Vectors and tables are recorded as text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ParamValue {
    /// A whole number.
    Integer(i64),
    /// A real number; finite, as scenario files are.
    Number(f64),
    /// A switch.
    Flag(bool),
    /// Anything else, as the scenario file would write it (strings without quotes).
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
}

/// Is a swept parameter a truth that is swept along? It distinguishes no run from another.
pub fn is_truth(name: &str) -> bool {
    name.starts_with("expect.") || name.starts_with("compare.truth.")
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
