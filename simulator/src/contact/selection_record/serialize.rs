//! Writes a problem and its answer into a record.

use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::methods::registry::MethodParameters;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::{Level, Problem, SoleProblem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::SoleState;
use crate::contact::model::turning::Turning;
use crate::contact::search::judge::{SUSPECT_FRICTION, SUSPECT_NORMAL, SUSPECT_TURNING};
use crate::contact::search::select::Selection;
use crate::contact::selection_record::{
    LevelName, SelectionRecord, SelectionResult, SoleRecord, ToleranceRecord, TurningRecord, Units, VertexRecord,
    Violations, state_name,
};

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

impl SelectionRecord {
    /// Records a problem before its selection; `last` is the last known solution. Names, reference
    /// points and the answer remain empty.
    pub fn from_problem(
        time: f64,
        (method, parameters): (&str, &MethodParameters),
        p: &Problem,
        input: &SelectionInput,
        forced: &PerSole<Option<SoleState>>,
        last: &Solution,
    ) -> Self {
        let (rules, tol) = (input.rules, &input.rules.tolerances);
        let sole = |(s, sole): (usize, &SoleProblem)| SoleRecord {
            name: String::new(),
            reference_m: [0.0; 3],
            body: Some(sole.body),
            radius_m: sole.radius,
            target: sole.target.into(),
            turning: sole.turning().map(|turning| TurningRecord::new(turning, rules.suspect[s])),
            previous: state_name(rules.previous[s]),
            forced: forced[s].map(state_name),
            suspect_normal: rules.suspect[s] & SUSPECT_NORMAL != 0,
            suspect_friction: rules.suspect[s] & SUSPECT_FRICTION != 0,
            last_wrench: last.wrench[6 * s..6 * s + 6].to_vec(),
            vertices: (0..sole.vertices.len()).map(|i| VertexRecord::new(&sole.vertices[i], s, i, last)).collect(),
        };
        SelectionRecord {
            time_s: time,
            method: method.to_owned(),
            parameters: *parameters,
            units: Units::at(p.level),
            level: match p.level {
                Level::Acceleration => LevelName::Acceleration,
                Level::Velocity => LevelName::Velocity,
            },
            event: input.event,
            scale: p.scale,
            step_s: p.step,
            w: p.w.clone(),
            b: p.b.clone(),
            exhaustive: rules.exhaustive,
            may_contradict: rules.may_contradict,
            stops: rules.stops,
            tolerances: ToleranceRecord {
                distance_m: tol.distance,
                velocity_m_per_s: tol.velocity,
                acceleration_m_per_s2: tol.acceleration,
                rest_m_per_s: tol.rest,
            },
            soles: p.soles.iter().enumerate().map(sole).collect(),
            answer: SelectionResult {
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

    /// Adds the answer of the method.
    pub fn set_answer(&mut self, selection: &Selection, solution: &Solution) {
        self.answer = SelectionResult::new(self.soles.len(), selection, solution);
    }
}

impl TurningRecord {
    fn new(turning: &Turning, suspect: u8) -> Self {
        TurningRecord {
            torsional_m: turning.torsional,
            rolling_m: turning.rolling,
            velocity_rad_per_s: turning.velocity.into(),
            bias: turning.bias.into(),
            spins: turning.spins,
            rolls: turning.rolls,
            holds_spin: turning.mode.holds_spin,
            holds_roll: turning.mode.holds_roll,
            direction: turning.mode.direction.into(),
            suspect: suspect & SUSPECT_TURNING != 0,
        }
    }
}

impl VertexRecord {
    fn new(v: &Vertex, s: usize, i: usize, last: &Solution) -> Self {
        VertexRecord {
            r_m: v.r.into(),
            bias: v.bias.into(),
            height_m: v.height,
            velocity_m_per_s: v.velocity.into(),
            mu_s: v.mu_s,
            mu_k: v.mu_k,
            viscous_s_per_m: v.viscous,
            direction: v.direction.into(),
            moving: v.moving,
            near: v.near,
            leaves: v.leaves,
            last_normal: last.normal[s][i],
            last_tangent: last.tangent[s][i].into(),
        }
    }
}

impl SelectionResult {
    pub(super) fn new(soles: usize, selection: &Selection, solution: &Solution) -> Self {
        let [geometric, kinematic, friction] = selection.assessment.levels;
        SelectionResult {
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
