//! `balance`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::task::balance_force::{ForceBalance, ForceBalanceChange};
use crate::scenario::format::task::balance_position::{PositionBalance, PositionBalanceChange};
use crate::text::quantity::{json, non_negative, some_positive};

/// Keeps the centre of mass above the soles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BalanceTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s. Left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
    /// The supporting soles. Left out: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soles: Option<Vec<String>>,
    /// Commanded quantity: efforts or positions.
    pub control: BalanceControl,
    /// Settings of `control = "force"`.
    #[serde(default)]
    pub force: ForceBalance,
    /// Settings of `control = "position"`.
    #[serde(default)]
    pub position: PositionBalance,
    /// New settings at given times, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub change: Vec<BalanceChange>,
}

/// New settings, in the table named after the control.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BalanceChange {
    /// Simulated time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// With `control = "force"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceBalanceChange>,
    /// With `control = "position"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<PositionBalanceChange>,
}

/// Commanded quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BalanceControl {
    /// Efforts: gravity compensation with optimally distributed contact forces.
    Force,
    /// Positions: feedback of the centre of mass through its Jacobian.
    Position,
}
