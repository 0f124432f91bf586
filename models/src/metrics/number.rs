//! Real numbers in JSON, which cannot represent infinities and NaN: those become `"inf"`, `"-inf"`
//! and `"NaN"`, so that the record of a diverged run can be read back.

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A real number with a JSON form for infinities and NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Real(pub f64);

impl Serialize for Real {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { serializer.serialize_f64(self.0) } else { serializer.collect_str(&self.0) }
    }
}

/// A measured value, for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Measure {
    /// A whole number.
    Count(u64),
    /// A real number; `"inf"`, `"-inf"` or `"NaN"` if it is not finite.
    Real(#[serde(serialize_with = "real::serialize")] f64),
    /// Not measured.
    Nothing,
}

impl From<Option<f64>> for Measure {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Measure::Nothing, Measure::Real)
    }
}

impl JsonSchema for Measure {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Measure".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A number; a word where it is infinite or none; null where there is nothing.",
            "anyOf": [{ "type": "number" }, { "enum": ["inf", "-inf", "NaN"] }, { "type": "null" }]
        })
    }
}

impl<'de> Deserialize<'de> for Real {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Number(f64),
            Text(String),
        }
        match Written::deserialize(deserializer)? {
            Written::Number(x) => Ok(Self(x)),
            Written::Text(text) => match text.as_str() {
                "inf" => Ok(Self(f64::INFINITY)),
                "-inf" => Ok(Self(f64::NEG_INFINITY)),
                "NaN" => Ok(Self(f64::NAN)),
                _ => Err(D::Error::custom(format!(
                    "`{text}` is not a number; expected a number, `inf`, `-inf` or `NaN`"
                ))),
            },
        }
    }
}

/// `#[serde(with = "number::real")]` for an `f64`.
pub mod real {
    use super::*;

    /// A number, or the text `inf`, `-inf` or `NaN`.
    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Real(*value).serialize(serializer)
    }

    /// The inverse of [`serialize`].
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Real::deserialize(deserializer).map(|r| r.0)
    }
}

/// `#[serde(with = "number::some_real")]` for an `Option<f64>` that may be infinite or NaN; `None`
/// is null.
pub mod some_real {
    use super::*;

    /// A number, null, or the text `inf`, `-inf` or `NaN`.
    pub fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(Real).serialize(serializer)
    }

    /// The inverse of [`serialize`].
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Ok(Option::<Real>::deserialize(deserializer)?.map(|r| r.0))
    }
}
