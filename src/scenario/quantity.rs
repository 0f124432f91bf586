//! Numbers with a meaning: what a field accepts, used as `deserialize_with`, and how JSON Schema says it.
//!
//! Whole numbers are accepted wherever a number is. That every number is finite is ensured when the file is read.

use std::{borrow::Cow, collections::BTreeMap, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer,
    de::{Error, Visitor},
};

fn number_where<'de, D: Deserializer<'de>>(d: D, holds: fn(f64) -> bool, must: &str) -> Result<f64, D::Error> {
    let value = f64::deserialize(d)?;
    if holds(value) { Ok(value) } else { Err(D::Error::custom(format!("must be {must}, not {value}"))) }
}

/// Above zero.
pub fn positive<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    number_where(d, |x| x > 0.0, "greater than 0")
}

/// Zero or above.
pub fn non_negative<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    number_where(d, |x| x >= 0.0, "0 or greater")
}

/// Zero or above, where leaving it out means something else.
pub fn some_non_negative<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    non_negative(d).map(Some)
}

/// Above zero, where leaving it out means something else.
pub fn some_positive<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    positive(d).map(Some)
}

/// From 0 to 1.
pub fn fraction<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    number_where(d, |x| (0.0..=1.0).contains(&x), "between 0 and 1")
}

/// The same, where leaving it out means something else.
pub fn some_fraction<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    fraction(d).map(Some)
}

/// A whole number of at least one.
pub fn count<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    match u32::deserialize(d)? {
        0 => Err(D::Error::custom("must be at least 1, not 0")),
        n => Ok(n),
    }
}

/// The same, where leaving it out means something else.
pub fn some_count<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u32>, D::Error> {
    count(d).map(Some)
}

/// Radians, or a string such as `"30 deg"`. For prismatic joints the number is metres.
pub struct Angle(pub f64);
/// Radians per second, or a string such as `"30 deg/s"`. For prismatic joints the number is metres per second.
struct AngularRate(f64);

/// Degrees or radians with their unit, `per` being what follows the unit.
fn parse_angle(text: &str, per: &str) -> Option<f64> {
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
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.per {
            "" => f.write_str("a number of radians or a string such as \"30 deg\""),
            per => write!(f, "a number of rad{per} or a string such as \"30 deg{per}\""),
        }
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        Ok(value)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
        parse_angle(text, self.per).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(text), &self))
    }
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(AngleVisitor { per: "" }).map(Angle)
    }
}

impl<'de> Deserialize<'de> for AngularRate {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(AngleVisitor { per: "/s" }).map(AngularRate)
    }
}

/// An angle.
pub fn angle<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    Angle::deserialize(d).map(|a| a.0)
}

/// An angle, where leaving it out means something else.
pub fn some_angle<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    angle(d).map(Some)
}

/// Three angles.
pub fn angles<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Angle; 3]>::deserialize(d)?.map(|a| a.0))
}

/// Three angular rates.
pub fn angular_rates<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    Ok(<[AngularRate; 3]>::deserialize(d)?.map(|a| a.0))
}

/// Joint name to joint position.
pub fn joint_positions<'de, D: Deserializer<'de>>(d: D) -> Result<BTreeMap<String, f64>, D::Error> {
    Ok(BTreeMap::<String, Angle>::deserialize(d)?.into_iter().map(|(name, a)| (name, a.0)).collect())
}

/// Joint name to joint velocity.
pub fn joint_velocities<'de, D: Deserializer<'de>>(d: D) -> Result<BTreeMap<String, f64>, D::Error> {
    Ok(BTreeMap::<String, AngularRate>::deserialize(d)?.into_iter().map(|(name, a)| (name, a.0)).collect())
}

/// Marker types that only say in JSON Schema what the functions above accept.
pub mod json {
    use super::*;

    macro_rules! described {
        ($($(#[$doc:meta])* $name:ident = $schema:tt;)*) => {$(
            $(#[$doc])*
            #[allow(dead_code)]
            pub struct $name;
            impl JsonSchema for $name {
                fn schema_name() -> Cow<'static, str> {
                    stringify!($name).into()
                }
                fn inline_schema() -> bool {
                    true
                }
                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    json_schema!($schema)
                }
            }
        )*};
    }

    described! {
        /// See [`positive`].
        Positive = {"type": "number", "exclusiveMinimum": 0};
        /// See [`non_negative`].
        NonNegative = {"type": "number", "minimum": 0};
        /// See [`fraction`].
        Fraction = {"type": "number", "minimum": 0, "maximum": 1};
        /// See [`count`].
        Count = {"type": "integer", "minimum": 1};
        /// A point seen from above; its height is not used.
        Corner = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3};
        /// Radians or a string.
        Angle = {"anyOf": [
            {"type": "number"},
            {"type": "string", "pattern": "^\\s*[-+0-9.eE]+\\s*(deg|degrees|°|rad|radians)\\s*$",
                "examples": ["30 deg"]},
        ]};
        /// Radians per second or a string.
        AngularRate = {"anyOf": [
            {"type": "number"},
            {"type": "string", "pattern": "^\\s*[-+0-9.eE]+\\s*(deg|degrees|°|rad|radians)\\s*/s\\s*$",
                "examples": ["30 deg/s"]},
        ]};
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_have_units() {
        // One rounding of the conversion.
        let near = |text: &str, per: &str, want: f64| {
            let got = parse_angle(text, per).unwrap();
            assert!((got - want).abs() <= 2.0 * f64::EPSILON, "{text}: {got}");
        };
        near("30 deg", "", std::f64::consts::FRAC_PI_6);
        near(" -90deg ", "", -std::f64::consts::FRAC_PI_2);
        near("45°", "", std::f64::consts::FRAC_PI_4);
        near("1e-1 rad", "", 0.1);
        near("180 deg/s", "/s", std::f64::consts::PI);
        for bad in ["30", "deg", "30 grad", "30 deg/s", "nan deg", "1e999 deg", "3 0 deg", ""] {
            assert_eq!(parse_angle(bad, ""), None, "{bad}");
        }
        assert_eq!(parse_angle("30 deg", "/s"), None);
    }
}
