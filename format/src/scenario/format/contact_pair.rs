//! `[[contact.pair]]`: rules for pairs of bodies.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::defaults;
use super::floor::Friction;

/// A rule for pairs of bodies. Of several rules for a pair the last one counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactPair {
    /// Names of two bodies: of a sole; of a link, unless `robot.contact` is `"soles"`; of an object (of
    /// a link of a model `OBJECT/LINK`); of terrain; `"floor"`. `*` matches any characters, `?` one.
    pub bodies: [String; 2],
    /// Coulomb friction between them: one number, or static and kinetic. Left out: the smaller coefficients of
    /// both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// False: they pass through each other. Soles and links of the robot always touch the floor.
    #[serde(default = "defaults::yes", skip_serializing_if = "is_true")]
    pub touch: bool,
}

fn is_true(value: &bool) -> bool {
    *value
}
