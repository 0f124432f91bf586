//! `drag`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{json, non_negative, some_positive};

/// Resistance of the air. At least one of `linear` and `quadratic` is above zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DragForce {
    /// The object it acts on; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// The link; left out: every link, each at its centre of mass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// Point of application in the link's frame, m. Left out: the centre of mass of the link with
    /// what is welded to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Force per speed through the air, N s/m; of each link.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub linear: f64,
    /// Force per square of that speed, N s^2/m^2: density times area times drag coefficient over 2;
    /// of each link.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub quadratic: f64,
    /// Velocity of the air in world axes, m/s.
    #[serde(default)]
    pub wind: [f64; 3],
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}
