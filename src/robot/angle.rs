//! Numbers that may be written as angles: `0.35`, `"20 deg"`, `"0.35 rad"`.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

/// A joint position as written in a robot file.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Angle {
    /// Radians; metres when a bare number is given for a prismatic joint.
    pub value: f64,
    /// True when a unit of angle was written.
    pub has_unit: bool,
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AngleVisitor)
    }
}

struct AngleVisitor;

impl Visitor<'_> for AngleVisitor {
    type Value = Angle;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a finite number in radians, or a string such as \"20 deg\" or \"0.35 rad\"")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Angle, E> {
        if value.is_finite() {
            Ok(Angle { value, has_unit: false })
        } else {
            Err(E::invalid_value(serde::de::Unexpected::Float(value), &self))
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Angle, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Angle, E> {
        let bad = || E::invalid_value(serde::de::Unexpected::Str(text), &self);
        let trimmed = text.trim();
        let (number, is_degrees) = match (trimmed.strip_suffix("deg"), trimmed.strip_suffix("rad")) {
            (Some(number), _) => (number, true),
            (None, Some(number)) => (number, false),
            (None, None) => return Err(bad()),
        };
        let number: f64 = number.trim().parse().map_err(|_| bad())?;
        if !number.is_finite() {
            return Err(bad());
        }
        Ok(Angle { value: if is_degrees { number.to_radians() } else { number }, has_unit: true })
    }
}

impl JsonSchema for Angle {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Angle".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Radians (metres for a prismatic joint), or a string with a unit such as \"20 deg\"",
            "anyOf": [
                { "type": "number" },
                { "type": "string", "pattern": "^\\s*[-+0-9.eE]+\\s*(deg|rad)\\s*$", "examples": ["30 deg"] },
            ]
        })
    }
}
