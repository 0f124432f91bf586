//! `[floor]`: a plane with friction.

use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, MapAccess, Visitor, value::MapAccessDeserializer},
};

use crate::text::quantity::{angles, json, non_negative, some_non_negative};

/// The floor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloorSpec {
    /// Coulomb friction: one number, or static and kinetic.
    pub friction: Friction,
    /// Height of the plane's point above the world's origin, m.
    pub height: f64,
    /// Tilt of the plane: roll, pitch, yaw as in URDF, rad.
    #[serde(deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// False: there is no plane, and `[[terrain]]` alone carries the robot. The other keys then
    /// define friction of terrain and the plane from which heights are measured.
    #[serde(skip_serializing_if = "is_true")]
    pub plane: bool,
    /// Regions with their own friction.
    pub patches: Vec<PatchSpec>,
}

/// A level plane at height 0.
impl Default for FloorSpec {
    fn default() -> Self {
        FloorSpec { friction: Friction::default(), height: 0.0, rpy: [0.0; 3], plane: true, patches: Vec::new() }
    }
}

fn is_true(value: &bool) -> bool {
    *value
}

/// Isotropic Coulomb friction. `static` is not smaller than `kinetic`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Friction {
    /// Coefficient while a sole sticks.
    #[serde(rename = "static")]
    pub static_: f64,
    /// Coefficient while it slides.
    pub kinetic: f64,
    /// Increase of the kinetic coefficient with the slip speed, s/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscous: Option<f64>,
    /// Greatest torsional moment of a point contact over its normal force, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torsional: Option<f64>,
    /// Greatest rolling moment of a point contact over its normal force, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rolling: Option<f64>,
}

impl Friction {
    /// Coulomb friction alone.
    pub fn coulomb(static_: f64, kinetic: f64) -> Self {
        Friction { static_, kinetic, viscous: None, torsional: None, rolling: None }
    }
}

impl Default for Friction {
    fn default() -> Self {
        Friction::coulomb(0.8, 0.6)
    }
}

/// A region of the floor with its own friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchSpec {
    /// Corners in order around the region, world x and y, m. On a tilted floor the region covers
    /// the points vertically above and below. A third number, the height, may be given and is not
    /// used.
    #[serde(deserialize_with = "corners")]
    #[schemars(with = "Vec<json::Corner>", length(min = 3))]
    pub polygon: Vec<[f64; 2]>,
    /// Friction in the region.
    pub friction: Friction,
}

struct Corner([f64; 2]);

impl<'de> Deserialize<'de> for Corner {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        match Vec::<f64>::deserialize(d)?[..] {
            [x, y] | [x, y, _] => Ok(Corner([x, y])),
            ref other => Err(D::Error::custom(format!(
                "must be `[x, y]` or `[x, y, z]`, not an array of length {}",
                other.len()
            ))),
        }
    }
}

fn corners<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<[f64; 2]>, D::Error> {
    Ok(Vec::<Corner>::deserialize(d)?.into_iter().map(|c| c.0).collect())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(rename = "static", deserialize_with = "non_negative")]
    static_: f64,
    #[serde(deserialize_with = "non_negative")]
    kinetic: f64,
    #[serde(default, deserialize_with = "some_non_negative")]
    viscous: Option<f64>,
    #[serde(default, deserialize_with = "some_non_negative")]
    torsional: Option<f64>,
    #[serde(default, deserialize_with = "some_non_negative")]
    rolling: Option<f64>,
}

struct FrictionVisitor;

impl<'de> Visitor<'de> for FrictionVisitor {
    type Value = Friction;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or `{ static, kinetic }`")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Friction, E> {
        if value >= 0.0 {
            return Ok(Friction::coulomb(value, value));
        }
        Err(E::custom(format!("must be 0 or greater, not {value}")))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Friction, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Friction, E> {
        self.visit_f64(value as f64)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Friction, A::Error> {
        let Table { static_, kinetic, viscous, torsional, rolling } =
            Table::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Friction { static_, kinetic, viscous, torsional, rolling })
    }
}

impl<'de> Deserialize<'de> for Friction {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(FrictionVisitor)
    }
}

impl JsonSchema for Friction {
    fn schema_name() -> Cow<'static, str> {
        "Friction".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Coulomb friction: one coefficient, or static (not smaller) and kinetic, with optional terms.",
            "anyOf": [
                {"type": "number", "minimum": 0},
                {
                    "type": "object",
                    "properties": {
                        "static": {"type": "number", "minimum": 0},
                        "kinetic": {"type": "number", "minimum": 0},
                        "viscous": {
                            "description": "Increase of the kinetic coefficient with the slip speed, s/m.",
                            "type": "number",
                            "minimum": 0
                        },
                        "torsional": {
                            "description": "Greatest torsional moment of a point contact over its normal force, m.",
                            "type": "number",
                            "minimum": 0
                        },
                        "rolling": {
                            "description": "Greatest rolling moment of a point contact over its normal force, m.",
                            "type": "number",
                            "minimum": 0
                        }
                    },
                    "required": ["static", "kinetic"],
                    "additionalProperties": false
                }
            ]
        })
    }
}
