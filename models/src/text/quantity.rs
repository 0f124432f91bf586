//! Ranges and units of numeric fields: readers for `deserialize_with`, and their JSON Schemas.
//!
//! Whole numbers are accepted wherever a number is. All numbers are finite: the TOML reader refuses
//! others.

use std::{borrow::Cow, collections::BTreeMap};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, de::Error};

use crate::text::angle::{ANGLE_PATTERN, Angle, AngularRate, RATE_PATTERN};

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

/// Zero or above, optional.
pub fn some_non_negative<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    non_negative(d).map(Some)
}

/// Above zero, optional.
pub fn some_positive<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    positive(d).map(Some)
}

/// From 0 to 1.
pub fn fraction<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    number_where(d, |x| (0.0..=1.0).contains(&x), "between 0 and 1")
}

/// The same, optional.
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

/// The same, optional.
pub fn some_count<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u32>, D::Error> {
    count(d).map(Some)
}

/// An angle.
pub fn angle<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    Angle::deserialize(d).map(|angle| angle.value)
}

/// An angle, optional.
pub fn some_angle<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    angle(d).map(Some)
}

/// Three angles.
pub fn angles<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Angle; 3]>::deserialize(d)?.map(|angle| angle.value))
}

/// Three angular rates.
pub fn angular_rates<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    Ok(<[AngularRate; 3]>::deserialize(d)?.map(|rate| rate.0))
}

/// Joint positions by joint name.
pub fn joint_positions<'de, D: Deserializer<'de>>(d: D) -> Result<BTreeMap<String, f64>, D::Error> {
    Ok(BTreeMap::<String, Angle>::deserialize(d)?.into_iter().map(|(name, angle)| (name, angle.value)).collect())
}

/// Joint velocities by joint name.
pub fn joint_velocities<'de, D: Deserializer<'de>>(d: D) -> Result<BTreeMap<String, f64>, D::Error> {
    Ok(BTreeMap::<String, AngularRate>::deserialize(d)?.into_iter().map(|(name, a)| (name, a.0)).collect())
}

/// Marker types for the JSON Schema of the functions above.
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
            {"type": "string", "pattern": ANGLE_PATTERN,
                "examples": ["30 deg"]},
        ]};
        /// Radians per second or a string.
        AngularRate = {"anyOf": [
            {"type": "number"},
            {"type": "string", "pattern": RATE_PATTERN,
                "examples": ["30 deg/s"]},
        ]};
    }
}
