//! `[contact]`, `[integrator]`: contact method and integration of a run.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::scenario::format::quantity::{count, fraction, json, non_negative, positive};

/// Contact method and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ContactSpec {
    /// Method that finds the contact states and forces.
    pub method: ContactMethod,
    /// Height below which a vertex touches the floor, m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub distance_tolerance: f64,
    /// Speed below which a vertex rests, m/s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub velocity_tolerance: f64,
    /// Acceleration that counts as none, m/s^2.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub acceleration_tolerance: f64,
    /// Coefficient of restitution: normal velocity after an impact over that before, 0 to 1.
    #[serde(deserialize_with = "fraction")]
    #[schemars(with = "json::Fraction")]
    pub restitution: f64,
    /// When contact changes are applied.
    pub events: EventHandling,
    /// Contact states imposed for a time.
    pub forced: Vec<ForcedState>,
    /// Parameters of method `penalty`.
    pub penalty: PenaltySpec,
    /// Parameters of method `lcp`.
    pub lcp: LcpSpec,
    /// Parameters of method `ncp`.
    pub ncp: NcpSpec,
}

impl Default for ContactSpec {
    fn default() -> Self {
        ContactSpec {
            method: ContactMethod::Exact,
            distance_tolerance: 1e-3,
            velocity_tolerance: 0.1,
            acceleration_tolerance: 0.1,
            restitution: 0.0,
            events: EventHandling::Locate,
            forced: Vec::new(),
            penalty: PenaltySpec::default(),
            lcp: LcpSpec::default(),
            ncp: NcpSpec::default(),
        }
    }
}

/// The contact method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactMethod {
    /// Exact Coulomb friction: contact states are tested until one is consistent.
    Exact,
    /// One decision per vertex from the present quantities, without trials.
    OneStep,
    /// Springs and dampers under every vertex, regularised friction.
    Penalty,
    /// Time stepping with a polyhedral friction cone: one linear complementarity problem per step.
    Lcp,
    /// Time stepping on the true friction cone, by projected Gauss-Seidel.
    Ncp,
}

impl ContactMethod {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            ContactMethod::Exact => "exact",
            ContactMethod::OneStep => "one-step",
            ContactMethod::Penalty => "penalty",
            ContactMethod::Lcp => "lcp",
            ContactMethod::Ncp => "ncp",
        }
    }
}

/// Parameters of method `penalty`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PenaltySpec {
    /// Stiffness of the floor under each vertex, N/m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub stiffness: f64,
    /// Damping of the floor under each vertex, N s/m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
    /// Speed below which friction is below its full size, m/s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub slip_velocity: f64,
}

impl Default for PenaltySpec {
    fn default() -> Self {
        PenaltySpec { stiffness: 1e5, damping: 300.0, slip_velocity: 1e-3 }
    }
}

/// Parameters of method `lcp`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LcpSpec {
    /// Number of friction directions, the first along the floor's x axis: even, 4 to 64.
    #[serde(deserialize_with = "facets")]
    #[schemars(range(min = 4, max = 64), extend("multipleOf" = 2))]
    pub facets: u32,
}

impl Default for LcpSpec {
    fn default() -> Self {
        LcpSpec { facets: 8 }
    }
}

fn facets<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let n = u32::deserialize(d)?;
    if n.is_multiple_of(2) && (4..=64).contains(&n) {
        return Ok(n);
    }
    Err(D::Error::custom(format!("must be an even number from 4 to 64, not {n}")))
}

/// Parameters of method `ncp`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NcpSpec {
    /// Most sweeps over the contact points in a step.
    #[serde(deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub iterations: u32,
    /// Change within a sweep at which the sweeps end, m/s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub tolerance: f64,
}

impl Default for NcpSpec {
    fn default() -> Self {
        NcpSpec { iterations: 200, tolerance: 1e-9 }
    }
}

/// When contact changes are applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EventHandling {
    /// At their own instants, located inside a step.
    Locate,
    /// At the ends of steps.
    Step,
}

/// A contact state imposed on one sole for a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForcedState {
    /// The sole.
    pub sole: String,
    /// `free`, or pattern and mode: `face-static`, `edge-1-dynamic`, `vertex-0-static` (counted from 0).
    #[serde(deserialize_with = "state_name")]
    #[schemars(regex(pattern = r"^(free|(face|(edge|vertex)-\d+)-(static|dynamic))$"))]
    pub state: String,
    /// First instant, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub from: f64,
    /// Last instant, s; left out: the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
}

fn state_name<'de, D: Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    let name = String::deserialize(d)?;
    if is_state_name(&name) {
        return Ok(name);
    }
    Err(D::Error::custom(format!(
        "cannot be {name:?}\na contact state is `free`, or `face`, `edge-N` or `vertex-N` followed by `-static` or `-dynamic`"
    )))
}

fn is_state_name(name: &str) -> bool {
    let Some((pattern, "static" | "dynamic")) = name.rsplit_once('-') else { return name == "free" };
    let counted = |kind: &str| {
        let digits = pattern.strip_prefix(kind).unwrap_or("");
        !digits.is_empty() && digits.len() < 10 && digits.bytes().all(|b| b.is_ascii_digit())
    };
    pattern == "face" || counted("edge-") || counted("vertex-")
}

/// Integration of the equations of motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IntegratorSpec {
    /// The method.
    pub method: IntegratorMethod,
    /// Relative error allowed per step, adaptive methods.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub relative_tolerance: f64,
    /// Absolute error allowed per step in addition, adaptive methods, SI units.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub absolute_tolerance: f64,
    /// Longest step, adaptive methods, s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub max_step: f64,
    /// Step of fixed-step methods, s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub step: f64,
}

impl Default for IntegratorSpec {
    fn default() -> Self {
        IntegratorSpec {
            method: IntegratorMethod::Dopri5,
            relative_tolerance: 1e-6,
            absolute_tolerance: 1e-8,
            max_step: 0.01,
            step: 1e-3,
        }
    }
}

/// The integration method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntegratorMethod {
    /// Dormand and Prince's embedded Runge-Kutta pair of order 5(4), adaptive.
    Dopri5,
    /// Bogacki and Shampine's embedded Runge-Kutta pair of order 3(2), adaptive.
    Bs23,
    /// The classical Runge-Kutta method of order 4, fixed step.
    Rk4,
    /// Semi-implicit Euler, fixed step.
    SemiImplicit,
}

impl IntegratorMethod {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            IntegratorMethod::Dopri5 => "dopri5",
            IntegratorMethod::Bs23 => "bs23",
            IntegratorMethod::Rk4 => "rk4",
            IntegratorMethod::SemiImplicit => "semi-implicit",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_state_name;

    #[test]
    fn contact_state_names() {
        for good in ["free", "face-static", "face-dynamic", "edge-1-dynamic", "vertex-0-static"] {
            assert!(is_state_name(good), "{good}");
        }
        for bad in [
            "",
            "free-static",
            "face",
            "edge-static",
            "vertex--static",
            "face-0-static",
            "edge-x-static",
            "face-sticky",
        ] {
            assert!(!is_state_name(bad), "{bad}");
        }
    }
}
