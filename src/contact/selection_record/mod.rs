//! A selection frozen: the contact problem as it was posed, before the choice turned any direction, and the answer, as
//! plain numbers that JSON carries bit for bit. [`SelectionRecord::replay`] chooses again from nothing but these.
//!
//! Axes are the floor's (z the normal). See [`crate::contact::model::problem`] for the equation `m = b + W w` and the order of its rows.
//!
//! `freeze` makes it, `thaw` brings it back; here is its shape.

mod deserialize;
mod serialize;

use crate::contact::methods::method::Parameters;
use crate::contact::model::state::{Mode, SoleState};
use serde::{Deserialize, Serialize};

/// A selection: what was asked, of whom, and what was answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelectionRecord {
    /// Simulated time, s.
    pub time_s: f64,
    /// The contact method asked.
    pub method: String,
    /// What the methods were told.
    #[serde(default)]
    pub parameters: Parameters,
    /// Units of the numbers whose names do not say them.
    pub units: Units,
    /// `acceleration`: motions are accelerations, wrenches forces. `velocity`: velocities after, impulses.
    pub level: LevelName,
    /// Did anything happen since the previous states were chosen?
    pub event: bool,
    /// What a force is small against, [`Problem::scale`](crate::contact::model::problem::Problem::scale).
    pub scale: f64,
    /// [`Problem::step`](crate::contact::model::problem::Problem::step).
    #[serde(default)]
    pub step_s: f64,
    /// W by rows, 6F x 6F.
    #[serde(rename = "W")]
    pub w: Vec<f64>,
    /// b, 6F: the motions without contact.
    pub b: Vec<f64>,
    /// The scenario's tolerances as they stood in the selection.
    pub tolerances: ToleranceRecord,
    /// The soles.
    pub soles: Vec<SoleRecord>,
    /// What was chosen.
    pub answer: Answer,
}

/// [`Level`](crate::contact::model::problem::Level) as a word.
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
    /// Of `b`, `answer.motion`: linear 3, angular 3.
    pub motion: String,
    /// Of wrenches: force 3, moment 3, at the reference point.
    pub wrench: String,
    /// Of `normal`, `tangent` and `scale`.
    pub force: String,
    /// Of `bias` and the first number of `target`; its others are angular motions about x and y.
    pub vertex: String,
}

/// [`Tolerances`](crate::contact::model::problem::Tolerances).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToleranceRecord {
    /// d.
    pub distance_m: f64,
    /// v_t.
    pub velocity_m_per_s: f64,
    /// a_t.
    pub acceleration_m_per_s2: f64,
    /// Speed below which a sliding vertex counts as at rest.
    pub rest_m_per_s: f64,
}

/// One sole before the choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoleRecord {
    /// Name in the robot file.
    pub name: String,
    /// Reference point of motion, wrench and vertices, relative to the floor's origin.
    pub reference_m: [f64; 3],
    /// Soles with the same number are fixed to the same body; each has its own when it is left out.
    #[serde(default)]
    pub body: Option<usize>,
    /// [`SoleProblem::radius`](crate::contact::model::problem::SoleProblem::radius).
    pub radius_m: f64,
    /// [`SoleProblem::target`](crate::contact::model::problem::SoleProblem::target).
    pub target: [f64; 3],
    /// State before: `free`, or pattern and mode, such as `face-static`, `edge-1-dynamic`, `face-pivot-2` (turning about
    /// vertex 2).
    pub previous: String,
    /// The state the scenario imposes, if it does: at the acceleration level as it stands, at the velocity level its
    /// pattern.
    pub forced: Option<String>,
    /// An event has put its normal load in doubt.
    pub suspect_normal: bool,
    /// An event has put its friction load in doubt.
    pub suspect_friction: bool,
    /// Wrench of the last known solution (forces), which the one-step method decides by.
    pub last_wrench: Vec<f64>,
    /// Its vertices in order around the polygon.
    pub vertices: Vec<VertexRecord>,
}

/// One vertex before the choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VertexRecord {
    /// Position from the sole's reference point.
    pub r_m: [f64; 3],
    /// Centripetal term, added to the motion of the vertex.
    pub bias: [f64; 3],
    /// Height above the floor.
    pub height_m: f64,
    /// Velocity.
    pub velocity_m_per_s: [f64; 3],
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// Unit direction of sliding; zero when it has none.
    pub direction: [f64; 2],
    /// Is the direction given by its velocity?
    pub moving: bool,
    /// At the velocity level: may it meet the floor?
    pub near: bool,
    /// Normal force of the last known solution, N.
    #[serde(rename = "last_normal_N")]
    pub last_normal: f64,
    /// Tangential force of the last known solution, N.
    #[serde(rename = "last_tangent_N")]
    pub last_tangent: [f64; 2],
}

/// What was chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Was a state valid?
    pub consistent: bool,
    /// Candidates tested.
    pub tested: usize,
    /// What the chosen states violate, in units of the tolerances, by level of importance.
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

/// [`crate::contact::search::judge::Verdict::levels`].
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

/// Why a frozen problem cannot be thawed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectionRecordError {
    /// A list has another length than the soles need.
    #[error("`{what}` has {found} numbers, {wanted} are wanted")]
    Length {
        /// Name of the list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// What the number of soles asks for.
        wanted: usize,
    },
    /// More soles, or more or fewer vertices, than the methods can do.
    #[error("{0}")]
    Size(String),
    /// A word that is no state of a sole with that many vertices.
    #[error("sole `{sole}` with {vertices} vertices has no state `{word}`")]
    State {
        /// The sole.
        sole: String,
        /// Number of its vertices.
        vertices: usize,
        /// What was read.
        word: String,
    },
    /// No such method.
    #[error("unknown contact method `{0}`")]
    Method(String),
}

/// The name of a state with its refinement: [`SoleState`]'s own, but `face-pivot-2` for turning about vertex 2.
pub fn state_name(state: SoleState) -> String {
    let plain = state.to_string();
    match state.mode {
        Mode::Pivoting(j) if state.is_dynamic() => plain.replace("dynamic", &format!("pivot-{j}")),
        _ => plain,
    }
}

/// The state of that name for a sole with `k` vertices.
pub fn state_named(name: &str, k: usize) -> Option<SoleState> {
    SoleState::refined(k).find(|&s| state_name(s) == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refined_state_has_a_name_of_its_own() {
        for k in [1, 2, 3, 4, 6] {
            for state in SoleState::refined(k) {
                assert_eq!(state_named(&state_name(state), k), Some(state), "{}", state_name(state));
            }
        }
        assert_eq!(state_name(state_named("edge-1-pivot-2", 4).unwrap()), "edge-1-pivot-2");
        assert_eq!(state_named("edge-1-pivot-3", 4), None, "vertex 3 is not on edge 1");
    }
}
