//! Angles and angular rates as files write them: `0.35` in radians, `"20 deg"`, `"0.35 rad"`, `"30
//! deg/s"`.
//!
//! For prismatic joints the plain number is metres or metres per second.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

/// Regular expression of an angle with its unit, for JSON Schema.
pub const ANGLE_PATTERN: &str = "^\\s*[-+0-9.eE]+\\s*(deg|degrees|°|rad|radians)\\s*$";
/// Regular expression of an angular rate with its unit.
pub const RATE_PATTERN: &str = "^\\s*[-+0-9.eE]+\\s*(deg|degrees|°|rad|radians)\\s*/s\\s*$";

/// An angle, or the position of a prismatic joint.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Angle {
    /// Radians; metres when a plain number is given for a prismatic joint.
    pub value: f64,
    /// True when a unit of angle was written.
    pub has_unit: bool,
}

/// An angular rate, rad/s, or the velocity of a prismatic joint, m/s.
pub struct AngularRate(pub f64);

/// Degrees or radians with their unit; `per` follows the unit.
fn parse(text: &str, per: &str) -> Option<f64> {
    let text = text.trim().strip_suffix(per)?.trim_end();
    let split = text.find(|c: char| !c.is_ascii_digit() && !"+-.eE_".contains(c)).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let number: f64 = number.trim().parse().ok().filter(|x: &f64| x.is_finite())?;
    match unit.trim() {
        "deg" | "°" | "degrees" => Some(number.to_radians()),
        "rad" | "radians" => Some(number),
        _ => None,
    }
}

struct AngleVisitor {
    per: &'static str,
}

impl Visitor<'_> for AngleVisitor {
    type Value = Angle;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.per {
            "" => f.write_str("a finite number of radians or a string such as \"30 deg\""),
            per => write!(f, "a finite number of rad{per} or a string such as \"30 deg{per}\""),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Angle, E> {
        match value.is_finite() {
            true => Ok(Angle { value, has_unit: false }),
            false => Err(E::invalid_value(Unexpected::Float(value), &self)),
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Angle, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Angle, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Angle, E> {
        let value = parse(text, self.per).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))?;
        Ok(Angle { value, has_unit: true })
    }
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(AngleVisitor { per: "" })
    }
}

impl<'de> Deserialize<'de> for AngularRate {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(AngleVisitor { per: "/s" }).map(|rate| AngularRate(rate.value))
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
                { "type": "string", "pattern": ANGLE_PATTERN, "examples": ["30 deg"] },
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_have_units() {
        // One rounding of the conversion.
        let near = |text: &str, per: &str, expected: f64| {
            let got = parse(text, per).unwrap();
            assert!((got - expected).abs() <= 2.0 * f64::EPSILON, "{text}: {got}");
        };
        near("30 deg", "", std::f64::consts::FRAC_PI_6);
        near(" -90deg ", "", -std::f64::consts::FRAC_PI_2);
        near("45°", "", std::f64::consts::FRAC_PI_4);
        near("1e-1 rad", "", 0.1);
        near("180 deg/s", "/s", std::f64::consts::PI);
        for bad in ["30", "deg", "30 grad", "30 deg/s", "nan deg", "1e999 deg", "3 0 deg", ""] {
            assert_eq!(parse(bad, ""), None, "{bad}");
        }
        assert_eq!(parse("30 deg", "/s"), None);
    }
}
