//! A selection frozen: the contact problem as it was posed, before the choice turned any direction, and the answer, as
//! plain numbers that JSON carries bit for bit. [`Frozen::replay`] chooses again from nothing but these.
//!
//! Axes are the floor's (z the normal). See [`super::problem`] for the equation `m = b + W w` and the order of its rows.

use super::candidate::Solution;
use super::judge::{Rules, SUSPECT_FRICTION, SUSPECT_NORMAL};
use super::method::{self, Method, Question};
use super::problem::{Level, Problem, SoleProblem, Tolerances, Vertex};
use super::select::Selection;
use super::state::{MAX_SOLES, Mode, SoleState, States};
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// A selection: what was asked, of whom, and what was answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frozen {
    /// Simulated time, s.
    pub time_s: f64,
    /// The contact method asked.
    pub method: String,
    /// Units of the numbers whose names do not say them.
    pub units: Units,
    /// `acceleration`: motions are accelerations, wrenches forces. `velocity`: velocities after, impulses.
    pub level: Word,
    /// Did anything happen since the previous states were chosen?
    pub event: bool,
    /// What a force is small against, [`Problem::scale`].
    pub scale: f64,
    /// W by rows, 6F x 6F.
    #[serde(rename = "W")]
    pub w: Vec<f64>,
    /// b, 6F: the motions without contact.
    pub b: Vec<f64>,
    /// The scenario's tolerances as they stood in the selection.
    pub tolerances: FrozenTolerances,
    /// The soles.
    pub soles: Vec<FrozenSole>,
    /// What was chosen.
    pub answer: Answer,
}

/// [`Level`] as a word.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Word {
    /// [`Level::Acceleration`].
    Acceleration,
    /// [`Level::Velocity`].
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

/// [`Tolerances`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenTolerances {
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
pub struct FrozenSole {
    /// Name in the robot file.
    pub name: String,
    /// Reference point of motion, wrench and vertices, relative to the floor's origin.
    pub reference_m: [f64; 3],
    /// [`SoleProblem::radius`].
    pub radius_m: f64,
    /// [`SoleProblem::target`].
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
    pub vertices: Vec<FrozenVertex>,
}

/// One vertex before the choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenVertex {
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

/// [`super::judge::Verdict::levels`].
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
pub enum FrozenError {
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

impl Units {
    fn at(level: Level) -> Self {
        let [motion, wrench, force, vertex] = match level {
            Level::Acceleration => ["m/s^2, rad/s^2", "N, N m", "N", "m/s^2"],
            Level::Velocity => ["m/s, rad/s", "N s, N m s", "N s", "m/s"],
        };
        let [motion, wrench, force, vertex] = [motion, wrench, force, vertex].map(str::to_owned);
        Units { motion, wrench, force, vertex }
    }
}

impl Frozen {
    /// Freezes a problem before the method sees it; `last` is the last known solution. Names, reference points and the
    /// answer are left empty.
    pub fn posed(
        time: f64,
        method: &str,
        p: &Problem,
        question: &Question,
        forced: &[Option<SoleState>],
        last: &Solution,
    ) -> Self {
        let (rules, tol) = (question.rules, &question.rules.tolerances);
        let sole = |(s, sole): (usize, &SoleProblem)| FrozenSole {
            name: String::new(),
            reference_m: [0.0; 3],
            radius_m: sole.radius,
            target: sole.target.into(),
            previous: state_name(rules.previous[s]),
            forced: forced[s].map(state_name),
            suspect_normal: rules.suspect[s] & SUSPECT_NORMAL != 0,
            suspect_friction: rules.suspect[s] & SUSPECT_FRICTION != 0,
            last_wrench: last.wrench[6 * s..6 * s + 6].to_vec(),
            vertices: (0..sole.vertices.len()).map(|i| FrozenVertex::new(&sole.vertices[i], s, i, last)).collect(),
        };
        Frozen {
            time_s: time,
            method: method.to_owned(),
            units: Units::at(p.level),
            level: match p.level {
                Level::Acceleration => Word::Acceleration,
                Level::Velocity => Word::Velocity,
            },
            event: question.event,
            scale: p.scale,
            w: p.w.clone(),
            b: p.b.clone(),
            tolerances: FrozenTolerances {
                distance_m: tol.distance,
                velocity_m_per_s: tol.velocity,
                acceleration_m_per_s2: tol.acceleration,
                rest_m_per_s: tol.rest,
            },
            soles: p.soles.iter().enumerate().map(sole).collect(),
            answer: Answer {
                consistent: false,
                tested: 0,
                violations: Violations { geometric: 0.0, kinematic: 0.0, friction: 0.0 },
                states: Vec::new(),
                wrench: Vec::new(),
                motion: Vec::new(),
                normal: Vec::new(),
                tangent: Vec::new(),
            },
        }
    }

    /// Adds what the method answered.
    pub fn answered(&mut self, selection: &Selection, solution: &Solution) {
        self.answer = Answer::new(self.soles.len(), selection, solution);
    }

    /// The problem as it was posed.
    ///
    /// # Errors
    /// Lists of wrong length.
    pub fn problem(&self) -> Result<Problem, FrozenError> {
        let n = 6 * self.soles.len();
        let length = |what, found, wanted| {
            if found == wanted { Ok(()) } else { Err(FrozenError::Length { what, found, wanted }) }
        };
        length("W", self.w.len(), n * n)?;
        length("b", self.b.len(), n)?;
        if self.soles.len() > MAX_SOLES {
            return Err(FrozenError::Size(format!("{} soles, at most {MAX_SOLES} are supported", self.soles.len())));
        }
        if let Some(s) = self.soles.iter().find(|s| s.vertices.is_empty() || s.vertices.len() > 64) {
            let message = format!("sole `{}` has {} vertices, 1 to 64 are supported", s.name, s.vertices.len());
            return Err(FrozenError::Size(message));
        }
        let sole = |s: &FrozenSole| SoleProblem {
            vertices: s.vertices.iter().map(FrozenVertex::thaw).collect(),
            radius: s.radius_m,
            target: s.target.into(),
        };
        Ok(Problem {
            level: match self.level {
                Word::Acceleration => Level::Acceleration,
                Word::Velocity => Level::Velocity,
            },
            w: self.w.clone(),
            b: self.b.clone(),
            soles: self.soles.iter().map(sole).collect(),
            scale: self.scale,
        })
    }

    /// Tolerances, states before and suspicions.
    ///
    /// # Errors
    /// A state that is none.
    pub fn rules(&self) -> Result<Rules, FrozenError> {
        let t = &self.tolerances;
        let mut rules = Rules {
            tolerances: Tolerances {
                distance: t.distance_m,
                velocity: t.velocity_m_per_s,
                acceleration: t.acceleration_m_per_s2,
                rest: t.rest_m_per_s,
            },
            previous: States::default(),
            suspect: [0; MAX_SOLES],
        };
        for (s, sole) in self.soles.iter().enumerate().take(MAX_SOLES) {
            rules.previous[s] = sole.state(&sole.previous)?;
            rules.suspect[s] = if sole.suspect_normal { SUSPECT_NORMAL } else { 0 }
                | if sole.suspect_friction { SUSPECT_FRICTION } else { 0 };
        }
        Ok(rules)
    }

    /// The states that the scenario imposes.
    ///
    /// # Errors
    /// A state that is none.
    pub fn forced(&self) -> Result<[Option<SoleState>; MAX_SOLES], FrozenError> {
        let mut forced = [None; MAX_SOLES];
        for (sole, forced) in self.soles.iter().zip(&mut forced) {
            *forced = sole.forced.as_ref().map(|word| sole.state(word)).transpose()?;
        }
        Ok(forced)
    }

    /// The last known solution, as far as any method reads it: wrenches and vertex forces.
    ///
    /// # Errors
    /// Lists of wrong length.
    pub fn last(&self) -> Result<Solution, FrozenError> {
        let mut last = Solution::new(&self.problem()?);
        for (s, sole) in self.soles.iter().enumerate() {
            if sole.last_wrench.len() != 6 {
                let found = sole.last_wrench.len();
                return Err(FrozenError::Length { what: "last_wrench", found, wanted: 6 });
            }
            last.wrench[6 * s..6 * s + 6].copy_from_slice(&sole.last_wrench);
            for (i, v) in sole.vertices.iter().enumerate() {
                last.normal[s][i] = v.last_normal;
                last.tangent[s][i] = v.last_tangent.into();
            }
        }
        Ok(last)
    }

    /// Chooses again, with the method that chose then. On the same machine kind and program the answer is the same bit
    /// for bit.
    ///
    /// # Errors
    /// Whatever of the above is wrong, or a method that does not exist.
    pub fn replay(&self) -> Result<Answer, FrozenError> {
        let (mut p, rules, forced, mut out) = (self.problem()?, self.rules()?, self.forced()?, self.last()?);
        let mut method = method::make(&self.method, &p).ok_or_else(|| FrozenError::Method(self.method.clone()))?;
        let level = p.level;
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f| allows(level, f, state));
        let question = Question { rules: &rules, event: self.event, allowed: &allowed };
        let selection = choose(method.as_mut(), &mut p, &question, &mut out);
        Ok(Answer::new(self.soles.len(), &selection, &out))
    }
}

/// May a sole on which the scenario imposes `forced` take `state`? An impulse may stick or slip whatever is imposed.
pub fn allows(level: Level, forced: SoleState, state: SoleState) -> bool {
    match level {
        Level::Acceleration => forced == state,
        Level::Velocity => forced.pattern == state.pattern,
    }
}

/// Asks the method at the problem's own level.
pub fn choose(method: &mut dyn Method, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
    match p.level {
        Level::Acceleration => method.select(p, question, out),
        Level::Velocity => method.impulse(p, question, out),
    }
}

impl FrozenSole {
    fn state(&self, word: &str) -> Result<SoleState, FrozenError> {
        let vertices = self.vertices.len();
        state_named(word, vertices).ok_or_else(|| FrozenError::State {
            sole: self.name.clone(),
            vertices,
            word: word.to_owned(),
        })
    }
}

impl FrozenVertex {
    fn new(v: &Vertex, s: usize, i: usize, last: &Solution) -> Self {
        FrozenVertex {
            r_m: v.r.into(),
            bias: v.bias.into(),
            height_m: v.height,
            velocity_m_per_s: v.velocity.into(),
            mu_s: v.mu_s,
            mu_k: v.mu_k,
            direction: v.direction.into(),
            moving: v.moving,
            near: v.near,
            last_normal: last.normal[s][i],
            last_tangent: last.tangent[s][i].into(),
        }
    }

    fn thaw(&self) -> Vertex {
        Vertex {
            r: Vector3::from(self.r_m),
            bias: Vector3::from(self.bias),
            height: self.height_m,
            velocity: Vector3::from(self.velocity_m_per_s),
            mu_s: self.mu_s,
            mu_k: self.mu_k,
            direction: Vector2::from(self.direction),
            moving: self.moving,
            near: self.near,
        }
    }
}

impl Answer {
    fn new(soles: usize, selection: &Selection, solution: &Solution) -> Self {
        let [geometric, kinematic, friction] = selection.verdict.levels;
        Answer {
            consistent: selection.consistent,
            tested: selection.tested,
            violations: Violations { geometric, kinematic, friction },
            states: (0..soles).map(|s| state_name(selection.states[s])).collect(),
            wrench: solution.wrench.clone(),
            motion: solution.motion.clone(),
            normal: solution.normal.clone(),
            tangent: solution.tangent.iter().map(|sole| sole.iter().map(|&t| t.into()).collect()).collect(),
        }
    }
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
