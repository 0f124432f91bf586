//! `[contact]`, `[integrator]`: contact method and integration of a run.

use std::{borrow::Cow, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{EnumAccess, Error, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::contact::methods::exact::{self, ExactParameters};
use crate::contact::methods::lcp::LcpParameters;
use crate::contact::methods::ncp::NcpParameters;
use crate::contact::methods::penalty::PenaltyParameters;
use crate::contact::methods::registry::{METHODS, MethodDescriptor, MethodParameters};

use super::contact_pair::ContactPair;
use crate::text::quantity::{fraction, json, non_negative, positive};

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
    /// Friction of pairs of bodies, and which of them do not touch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pair: Vec<ContactPair>,
    /// Parameters of method `exact`.
    pub exact: ExactParameters,
    /// Parameters of method `penalty`.
    pub penalty: PenaltyParameters,
    /// Parameters of method `lcp`.
    pub lcp: LcpParameters,
    /// Parameters of method `ncp`.
    pub ncp: NcpParameters,
}

impl ContactSpec {
    /// Parameters of all methods.
    pub fn parameters(&self) -> MethodParameters {
        MethodParameters { exact: self.exact, penalty: self.penalty, lcp: self.lcp, ncp: self.ncp }
    }
}

impl Default for ContactSpec {
    fn default() -> Self {
        ContactSpec {
            method: ContactMethod::default(),
            distance_tolerance: 1e-3,
            velocity_tolerance: 0.1,
            acceleration_tolerance: 0.1,
            restitution: 0.0,
            events: EventHandling::Locate,
            forced: Vec::new(),
            pair: Vec::new(),
            exact: ExactParameters::default(),
            penalty: PenaltyParameters::default(),
            lcp: LcpParameters::default(),
            ncp: NcpParameters::default(),
        }
    }
}

/// The contact method, by name.
#[derive(Clone, Copy)]
pub struct ContactMethod(&'static MethodDescriptor);

impl ContactMethod {
    /// The descriptor of the method.
    pub fn descriptor(self) -> &'static MethodDescriptor {
        self.0
    }

    /// The name in files and tables.
    pub fn name(self) -> &'static str {
        self.0.name
    }
}

impl Default for ContactMethod {
    fn default() -> Self {
        ContactMethod(&exact::DESCRIPTOR)
    }
}

impl PartialEq for ContactMethod {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for ContactMethod {}

impl fmt::Debug for ContactMethod {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for ContactMethod {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for ContactMethod {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        // Read as an enum, so that errors about unknown names equal those of other enums.
        const NAMES: [&str; METHODS.len()] = {
            let (mut names, mut i) = ([""; METHODS.len()], 0);
            while i < METHODS.len() {
                names[i] = METHODS[i].name;
                i += 1;
            }
            names
        };
        struct Name;
        impl<'de> Visitor<'de> for Name {
            type Value = ContactMethod;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a contact method")
            }
            fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<ContactMethod, A::Error> {
                let (name, variant) = data.variant::<String>()?;
                variant.unit_variant()?;
                let method = MethodDescriptor::named(&name);
                method.map(ContactMethod).ok_or_else(|| Error::unknown_variant(&name, &NAMES))
            }
        }
        d.deserialize_enum("ContactMethod", &NAMES, Name)
    }
}

impl JsonSchema for ContactMethod {
    fn schema_name() -> Cow<'static, str> {
        "ContactMethod".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let methods = METHODS.map(|m| json_schema!({ "description": m.doc, "type": "string", "const": m.name }));
        json_schema!({ "description": "The contact method.", "oneOf": methods })
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
    /// `free`, or pattern and mode: `face-static`, `edge-1-dynamic`, `vertex-0-static` (counted
    /// from 0).
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
    /// Rang and Angermann's Rosenbrock pair ROS34PW2 of order 3(2), adaptive: drives, joint friction and stops,
    /// springs and dampers are implicit and do not limit its steps.
    Rosenbrock,
    /// Backward differentiation formulas of order 1 to 5, adaptive, with the same forces implicit: one evaluation a
    /// step where the motion is smooth. `rosenbrock` takes the first steps after a jump.
    Bdf,
    /// `dopri5`, or `bdf` while stiff forces limit the steps of `dopri5`.
    Auto,
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
            IntegratorMethod::Rosenbrock => "rosenbrock",
            IntegratorMethod::Bdf => "bdf",
            IntegratorMethod::Auto => "auto",
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
