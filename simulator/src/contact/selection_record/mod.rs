//! Records of selections: a contact problem before its selection, and the answer, as plain numbers.
//!
//! JSON preserves all bits, and [`SelectionRecord::replay`] repeats the selection from a record.
//!
//! Axes are the floor's (z is the normal). See [`crate::contact::model::problem`] for the equation
//! `m = b + W w` and the order of its rows.
//!
//! This module defines the format; `serialize` fills a record, `deserialize` restores the problem.

mod deserialize;
mod serialize;

use crate::contact::methods::registry::MethodParameters;
use crate::contact::model::state::{Mode, SoleState};
use serde::{Deserialize, Serialize};

/// One selection: method, problem and answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelectionRecord {
    /// Simulated time, s.
    pub time_s: f64,
    /// Name of the contact method.
    pub method: String,
    /// Parameters of the methods.
    #[serde(default)]
    pub parameters: MethodParameters,
    /// Units of numbers whose names do not contain them.
    pub units: Units,
    /// `acceleration`: motions are accelerations, wrenches forces. `velocity`: velocities after,
    /// impulses.
    pub level: LevelName,
    /// Whether an event has occurred since the previous states were chosen.
    pub event: bool,
    /// Typical load,
    /// [`Problem::scale`](crate::contact::model::problem::Problem::scale).
    pub scale: f64,
    /// [`Problem::step`](crate::contact::model::problem::Problem::step).
    #[serde(default)]
    pub step_s: f64,
    /// Matrix W by rows, 6F x 6F.
    #[serde(rename = "W")]
    pub w: Vec<f64>,
    /// Vector b, 6F: the motions without contact.
    pub b: Vec<f64>,
    /// Whether all states were searched as a last resort.
    #[serde(default = "without_the_key")]
    pub exhaustive: bool,
    /// Whether conditions may contradict each other.
    #[serde(default)]
    pub may_contradict: bool,
    /// Whether motion that a new state does not allow was to be stopped; otherwise vertices slide on along it.
    #[serde(default = "without_the_key")]
    pub stops: bool,
    /// Tolerances that applied in the selection.
    pub tolerances: ToleranceRecord,
    /// Soles, in the order of the rows.
    pub soles: Vec<SoleRecord>,
    /// The answer of the method.
    pub answer: SelectionResult,
}

/// Records without the key are of programs that always searched all states, and always stopped motion.
fn without_the_key() -> bool {
    true
}

/// [`Level`](crate::contact::model::problem::Level) as written in files.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LevelName {
    /// Accelerations and forces.
    Acceleration,
    /// Velocities and impulses.
    Velocity,
}

/// Units at the level of the problem, in the order of the rows of a sole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Units of `b` and `answer.motion`: linear 3, angular 3.
    pub motion: String,
    /// Units of wrenches: force 3, moment 3, at the reference point.
    pub wrench: String,
    /// Unit of `normal`, `tangent` and `scale`.
    pub force: String,
    /// Unit of `bias` and the first number of `target`; its others are angular motions about x and
    /// y.
    pub vertex: String,
}

/// [`Tolerances`](crate::contact::model::problem::Tolerances).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToleranceRecord {
    /// Distance tolerance d.
    pub distance_m: f64,
    /// Velocity tolerance v_t.
    pub velocity_m_per_s: f64,
    /// Acceleration tolerance a_t.
    pub acceleration_m_per_s2: f64,
    /// Speed below which a sliding vertex counts as at rest.
    pub rest_m_per_s: f64,
}

/// One sole before the selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoleRecord {
    /// Name in the robot file.
    pub name: String,
    /// Reference point of motion, wrench and vertices, relative to the floor's origin.
    pub reference_m: [f64; 3],
    /// Soles with the same number belong to the same body; without it each sole has its own body.
    #[serde(default)]
    pub body: Option<usize>,
    /// [`SoleProblem::radius`](crate::contact::model::problem::SoleProblem::radius).
    pub radius_m: f64,
    /// [`SoleProblem::target`](crate::contact::model::problem::SoleProblem::target).
    pub target: [f64; 3],
    /// Previous state: `free`, or pattern and mode, such as `face-static`, `edge-1-dynamic`,
    /// `face-pivot-2` (turning about vertex 2).
    pub previous: String,
    /// Its torsional and rolling friction; left out if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turning: Option<TurningRecord>,
    /// State that the scenario imposes, if any: in full at the acceleration level, its pattern
    /// alone at the velocity level.
    pub forced: Option<String>,
    /// An event has put its normal load in doubt.
    pub suspect_normal: bool,
    /// An event has put its friction load in doubt.
    pub suspect_friction: bool,
    /// Wrench of the last known solution (forces), an input of the one-step method.
    pub last_wrench: Vec<f64>,
    /// Its vertices in order around the polygon.
    pub vertices: Vec<VertexRecord>,
}

/// [`Turning`](crate::contact::model::turning::Turning) before the selection.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TurningRecord {
    /// Greatest torsional moment over the normal force.
    pub torsional_m: f64,
    /// Greatest rolling moment over the normal force.
    pub rolling_m: f64,
    /// Relative angular velocity.
    pub velocity_rad_per_s: [f64; 3],
    /// What the rate of that velocity has besides the angular motion.
    pub bias: [f64; 3],
    /// Whether the velocity gives the direction of the spin.
    pub spins: bool,
    /// Whether it gives that of the roll.
    pub rolls: bool,
    /// Whether the spin was held.
    pub holds_spin: bool,
    /// Whether the roll was held.
    pub holds_roll: bool,
    /// Directions of what was not held.
    pub direction: [f64; 3],
    /// An event has put its moments in doubt.
    pub suspect: bool,
}

/// One vertex before the selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexRecord {
    /// Position from the sole's reference point.
    pub r_m: [f64; 3],
    /// Centripetal term in the motion of the vertex.
    pub bias: [f64; 3],
    /// Height above the floor.
    pub height_m: f64,
    /// Velocity.
    pub velocity_m_per_s: [f64; 3],
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// Increase of the kinetic coefficient with the slip speed, s/m; left out if zero.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub viscous_s_per_m: f64,
    /// Unit direction of sliding; zero when it has none.
    pub direction: [f64; 2],
    /// Whether its velocity gives the direction.
    pub moving: bool,
    /// At the velocity level: whether it may meet the floor.
    pub near: bool,
    /// Whether it leaves the other body, so that no state clamps it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leaves: bool,
    /// Normal force of the last known solution, N.
    #[serde(rename = "last_normal_N")]
    pub last_normal: f64,
    /// Tangential force of the last known solution, N.
    #[serde(rename = "last_tangent_N")]
    pub last_tangent: [f64; 2],
}

/// Result of the selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelectionResult {
    /// Whether a valid state was found.
    pub consistent: bool,
    /// Candidates tested.
    pub tested: usize,
    /// Violations of the chosen states, in units of the tolerances, by level.
    pub violations: Violations,
    /// State of each sole.
    pub states: Vec<String>,
    /// Sole wrenches w, 6F.
    pub wrench: Vec<f64>,
    /// Sole motions m = b + W w, 6F.
    pub motion: Vec<f64>,
    /// Normal force of each vertex, by sole.
    pub normal: Vec<Vec<f64>>,
    /// Tangential force of each vertex, by sole.
    pub tangent: Vec<Vec<[f64; 2]>>,
}

/// [`crate::contact::search::judge::Assessment::levels`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Violations {
    /// Vertices below the floor, or clamped above it.
    pub geometric: f64,
    /// Vertices driven into the floor, or pulled by it.
    pub kinematic: f64,
    /// Friction outside its law.
    pub friction: f64,
}

/// Error in a recorded problem.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectionRecordError {
    /// A list has another length than the soles need.
    #[error("`{what}` has {found} numbers, expected {expected}")]
    Length {
        /// Name of the list.
        what: &'static str,
        /// Its length in the record.
        found: usize,
        /// Length that the number of soles requires.
        expected: usize,
    },
    /// Unsupported number of soles or vertices.
    #[error("{0}")]
    Size(String),
    /// Unknown state for a sole with this number of vertices.
    #[error("sole `{sole}` with {vertices} vertices has no state `{name}`")]
    State {
        /// The sole.
        sole: String,
        /// Number of its vertices.
        vertices: usize,
        /// Name found in the record.
        name: String,
    },
    /// Unknown method.
    #[error("unknown contact method `{0}`")]
    Method(String),
}

/// The name of a state: that of [`SoleState`], but for example `face-pivot-2` for turning about
/// vertex 2.
pub fn state_name(state: SoleState) -> String {
    let plain = state.to_string();
    match state.mode {
        Mode::Pivoting(j) if state.is_dynamic() => plain.replace("dynamic", &format!("pivot-{j}")),
        _ => plain,
    }
}

/// The state named `name` of a sole with `k` vertices.
pub fn state_named(name: &str, k: usize) -> Option<SoleState> {
    SoleState::refined(k).find(|&s| state_name(s) == name)
}

/// Whether a number need not be written.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_refined_states_are_unique_and_read_back() {
        for k in [1, 2, 3, 4, 6] {
            for state in SoleState::refined(k) {
                assert_eq!(state_named(&state_name(state), k), Some(state), "{}", state_name(state));
            }
        }
        assert_eq!(state_name(state_named("edge-1-pivot-2", 4).unwrap()), "edge-1-pivot-2");
        assert_eq!(state_named("edge-1-pivot-3", 4), None, "vertex 3 is not on edge 1");
    }
}
