//! Restores a problem from its record and repeats the selection.

use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::{Level, Problem, SoleProblem, Tolerances, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::model::turning::{Turning, TurningMode};
use crate::contact::search::judge::{Rules, SUSPECT_FRICTION, SUSPECT_NORMAL, SUSPECT_TURNING};
use crate::contact::selection_record::{
    LevelName, SelectionRecord, SelectionRecordError, SelectionResult, SoleRecord, TurningRecord, VertexRecord,
    state_named,
};
use nalgebra::{Vector2, Vector3};

impl SelectionRecord {
    /// The problem before its selection.
    ///
    /// # Errors
    /// Lists of wrong length.
    pub fn problem(&self) -> Result<Problem, SelectionRecordError> {
        let n = 6 * self.soles.len();
        let length = |what, found, expected| {
            if found == expected { Ok(()) } else { Err(SelectionRecordError::Length { what, found, expected }) }
        };
        length("W", self.w.len(), n * n)?;
        length("b", self.b.len(), n)?;
        if let Some(s) = self.soles.iter().find(|s| s.vertices.is_empty() || s.vertices.len() > 64) {
            let message = format!("sole `{}` has {} vertices, 1 to 64 are supported", s.name, s.vertices.len());
            return Err(SelectionRecordError::Size(message));
        }
        let sole = |(i, s): (usize, &SoleRecord)| SoleProblem {
            vertices: s.vertices.iter().map(VertexRecord::to_vertex).collect(),
            radius: s.radius_m,
            body: s.body.unwrap_or(i),
            position: s.reference_m.into(),
            target: s.target.into(),
            turning: s.turning.map_or(Turning::default(), TurningRecord::to_turning),
        };
        Ok(Problem {
            level: match self.level {
                LevelName::Acceleration => Level::Acceleration,
                LevelName::Velocity => Level::Velocity,
            },
            w: self.w.clone(),
            b: self.b.clone(),
            soles: self.soles.iter().enumerate().map(sole).collect(),
            scale: self.scale,
            step: self.step_s,
        })
    }

    /// Tolerances, previous states and suspect soles.
    ///
    /// # Errors
    /// Names of unknown states.
    pub fn rules(&self) -> Result<Rules, SelectionRecordError> {
        let t = &self.tolerances;
        let tolerances = Tolerances {
            distance: t.distance_m,
            velocity: t.velocity_m_per_s,
            acceleration: t.acceleration_m_per_s2,
            rest: t.rest_m_per_s,
        };
        let (exhaustive, may_contradict, stops) = (self.exhaustive, self.may_contradict, self.stops);
        let mut rules = Rules { exhaustive, may_contradict, stops, ..Rules::new(tolerances, States::default()) };
        for (s, sole) in self.soles.iter().enumerate() {
            rules.previous[s] = sole.state(&sole.previous)?;
            rules.suspect[s] = if sole.suspect_normal { SUSPECT_NORMAL } else { 0 }
                | if sole.suspect_friction { SUSPECT_FRICTION } else { 0 }
                | if sole.turning.is_some_and(|t| t.suspect) { SUSPECT_TURNING } else { 0 };
        }
        Ok(rules)
    }

    /// The states that the scenario imposes.
    ///
    /// # Errors
    /// Names of unknown states.
    pub fn forced(&self) -> Result<PerSole<Option<SoleState>>, SelectionRecordError> {
        let mut forced = PerSole::default();
        for (s, sole) in self.soles.iter().enumerate() {
            forced[s] = sole.forced.as_ref().map(|name| sole.state(name)).transpose()?;
        }
        Ok(forced)
    }

    /// The wrenches and vertex forces of the last known solution.
    ///
    /// # Errors
    /// Lists of wrong length.
    pub fn last(&self) -> Result<Solution, SelectionRecordError> {
        let mut last = Solution::new(&self.problem()?);
        for (s, sole) in self.soles.iter().enumerate() {
            if sole.last_wrench.len() != 6 {
                let found = sole.last_wrench.len();
                return Err(SelectionRecordError::Length { what: "last_wrench", found, expected: 6 });
            }
            last.wrench[6 * s..6 * s + 6].copy_from_slice(&sole.last_wrench);
            for (i, v) in sole.vertices.iter().enumerate() {
                last.normal[s][i] = v.last_normal;
                last.tangent[s][i] = v.last_tangent.into();
            }
        }
        Ok(last)
    }

    /// Repeats the selection with the recorded method. The same program on the same kind of machine
    /// gives an answer equal to the last bit.
    ///
    /// # Errors
    /// A record that is not a valid problem, or an unknown method.
    pub fn replay(&self) -> Result<SelectionResult, SelectionRecordError> {
        let (mut p, rules, forced, mut out) = (self.problem()?, self.rules()?, self.forced()?, self.last()?);
        let method = MethodDescriptor::named(&self.method);
        let method = method.ok_or_else(|| SelectionRecordError::Method(self.method.clone()))?;
        let mut method = (method.solver)(&self.parameters, &p);
        let level = p.level;
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f| allows(level, f, state));
        let input = SelectionInput { rules: &rules, event: self.event, allowed: &allowed, cancel: None };
        let selection = match level {
            Level::Acceleration => method.select(&mut p, &input, &mut out),
            Level::Velocity => method.impulse(&mut p, &input, &mut out),
        };
        Ok(SelectionResult::new(self.soles.len(), &selection, &out))
    }
}

/// Whether a sole with the imposed state `forced` may take `state`. In an impulse only the pattern
/// is imposed.
fn allows(level: Level, forced: SoleState, state: SoleState) -> bool {
    match level {
        Level::Acceleration => forced == state,
        Level::Velocity => forced.pattern == state.pattern,
    }
}

impl SoleRecord {
    fn state(&self, name: &str) -> Result<SoleState, SelectionRecordError> {
        let vertices = self.vertices.len();
        state_named(name, vertices).ok_or_else(|| SelectionRecordError::State {
            sole: self.name.clone(),
            vertices,
            name: name.to_owned(),
        })
    }
}

impl TurningRecord {
    fn to_turning(self) -> Turning {
        Turning {
            torsional: self.torsional_m,
            rolling: self.rolling_m,
            velocity: self.velocity_rad_per_s.into(),
            bias: self.bias.into(),
            spins: self.spins,
            rolls: self.rolls,
            mode: TurningMode {
                holds_spin: self.holds_spin,
                holds_roll: self.holds_roll,
                direction: self.direction.into(),
            },
        }
    }
}

impl VertexRecord {
    fn to_vertex(&self) -> Vertex {
        Vertex {
            r: Vector3::from(self.r_m),
            bias: Vector3::from(self.bias),
            height: self.height_m,
            velocity: Vector3::from(self.velocity_m_per_s),
            mu_s: self.mu_s,
            mu_k: self.mu_k,
            viscous: self.viscous_s_per_m,
            direction: Vector2::from(self.direction),
            moving: self.moving,
            settles: false,
            near: self.near,
            leaves: self.leaves,
        }
    }
}
