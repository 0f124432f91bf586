//! Event functions of the current contact states: positive while the states are valid.
//!
//! Event location finds the instant at which the first of them reaches zero.
//!
//! | function | event when it reaches zero |
//! |---|---|
//! | height of an unclamped vertex above the floor | touch-down |
//! | the same within the tolerance band: remaining depth and approach speed | entering the floor |
//! | normal margin of a clamped pattern | lift-off, or the centre of pressure leaves it |
//! | friction margin of a static pattern or a pivot | slip onset |
//! | sliding velocity along the reference direction | stick, or reversal |
//! | margin of a held torsional or rolling moment | spin or roll begins |
//! | spin or roll along its reference direction | it ends, or reverses |
//! | height of a vertex over a compliant floor, or its depth | entering or leaving it |
//! | gap of the nearest point of bodies that is no vertex | touch-down of another point |
//! | acceleration allowed in clamped directions less the greatest one | conditions that contradict each other |
//! | distance of a sliding or rolling vertex to the border of its friction region | other friction |

use crate::contact::methods::penalty;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::{Problem, TOUCHING, Tolerances};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, SoleState, States};
use crate::contact::model::turning::{self, TurningMode};
use crate::contact::search::judge::{
    CLEAR, CONTRADICTED, SUSPECT_FRICTION, SUSPECT_NORMAL, SUSPECT_TURNING, greatest_contradiction, margin,
};
use nalgebra::Vector2;

/// Inputs of event functions: the contact problem, the current states and their solution.
#[derive(Clone, Copy)]
pub(crate) struct ContactInForce<'a> {
    /// Contact problem.
    pub problem: &'a Problem,
    /// The states.
    pub states: &'a States,
    /// Their solution, with vertex forces.
    pub solution: &'a Solution,
    /// Reference directions of the sliding vertices of each sole, unit vectors in the floor.
    pub directions: &'a [Vec<Vector2<f64>>],
    /// Reference modes of torsional and rolling friction, by sole.
    pub turning: &'a [TurningMode],
    /// Tolerances.
    pub tolerances: &'a Tolerances,
    /// Whether forces follow heights and velocities by a compliant law.
    pub is_compliant: bool,
    /// Regions of different friction; `None` if friction is uniform.
    pub regions: Option<&'a dyn FrictionBorders>,
    /// Contacts that are no vertices of the problem.
    pub touching: &'a dyn ContactGaps,
    /// Whether conditions may contradict each other: motions are prescribed, or links coupled.
    pub may_contradict: bool,
    /// Whether the state of a sole is imposed; it then ends at a set time, not at an event.
    pub is_imposed: &'a dyn Fn(usize) -> bool,
}

/// Regions of the floor with different friction, as event functions use them.
pub(crate) trait FrictionBorders {
    /// Vertex `i` of sole `s` projected onto the world's x and y, m.
    fn seen_from_above(&self, s: usize, i: usize) -> Vector2<f64>;
    /// Whether the vertices of a polygon move while they are static, as the point below a ball does.
    fn rolls(&self, s: usize) -> bool;
    /// Distance of the vertex to the border of its region, m; negative beyond it.
    fn border(&self, s: usize, i: usize) -> f64;
    /// Fraction of the straight path from `from` to the present position after which the vertex is
    /// probably beyond the border; `None` if it stays inside.
    fn crossing(&self, s: usize, i: usize, from: &Vector2<f64>) -> Option<f64>;
}

/// Bodies that may touch with points that are no vertices of the problem.
pub(crate) trait ContactGaps {
    /// Number of functions.
    fn number(&self) -> usize;
    /// Function `i`, positive while no such point touches: its gap, or a lower bound for it above zero, m.
    fn gap(&self, i: usize) -> f64;
}

/// Number of event functions for which memory is reserved.
pub(crate) const USUAL_FUNCTIONS: usize = 512;

#[derive(Clone, Copy, PartialEq, Debug)]
enum Function {
    Height(usize, usize),
    /// With the allowed depth, m: d, or twice the present depth.
    Band(usize, usize, f64),
    /// With whether the vertex is inside the compliant floor.
    Surface(usize, usize, bool),
    Normal(usize),
    Friction(usize),
    /// With the allowed speed of backward sliding, m/s.
    Slide(usize, usize, f64),
    Border(usize, usize, Vector2<f64>),
    /// Margins of held torsional and rolling moments.
    Turning(usize),
    /// Spin along its direction, with the allowed backward one, rad/s.
    Spin(usize, f64),
    /// The same of the roll.
    Roll(usize, f64),
    Touch(usize),
    Contradiction,
}

/// The event functions of one step.
#[derive(Clone)]
pub(crate) struct EventFunctions {
    functions: Vec<Function>,
    /// Functions negative at the start, because no valid state was found: ignored until the end of
    /// the step.
    overlooked: Vec<usize>,
    /// Functions of the step before.
    before: Vec<Function>,
}

impl EventFunctions {
    /// Reserves memory for the functions of a usual step.
    pub fn new() -> Self {
        EventFunctions {
            functions: Vec::with_capacity(USUAL_FUNCTIONS),
            overlooked: Vec::with_capacity(USUAL_FUNCTIONS),
            before: Vec::with_capacity(USUAL_FUNCTIONS),
        }
    }

    /// Selects the functions of a step from the states and vertices at its start.
    pub fn begin(&mut self, now: &ContactInForce) {
        std::mem::swap(&mut self.functions, &mut self.before);
        self.functions.clear();
        self.overlooked.clear();
        let p = now.problem;
        self.functions.extend((0..now.touching.number()).map(Function::Touch));
        if now.is_compliant {
            for (s, sole) in p.soles.iter().enumerate() {
                let function = |(i, v)| Function::Surface(s, i, penalty::is_inside(v));
                self.functions.extend(sole.vertices.iter().enumerate().map(function));
            }
            return;
        }
        for (s, sole) in p.soles.iter().enumerate() {
            let state = now.states[s];
            let k = sole.vertices.len();
            let ends_by_event = !(now.is_imposed)(s);
            for (i, v) in sole.vertices.iter().enumerate() {
                if !state.clamps(i, k) {
                    let depth = now.tolerances.distance.max(-2.0 * v.height);
                    let function =
                        if v.height > TOUCHING { Function::Height(s, i) } else { Function::Band(s, i, depth) };
                    self.functions.extend(ends_by_event.then_some(function));
                } else if state.is_dynamic() && state.mode != Mode::Pivoting(i as u8) {
                    self.functions.push(Function::Slide(s, i, 0.0));
                    if let Some(regions) = now.regions {
                        self.functions.push(Function::Border(s, i, regions.seen_from_above(s, i)));
                    }
                } else if let Some(regions) = now.regions.filter(|regions| regions.rolls(s)) {
                    self.functions.push(Function::Border(s, i, regions.seen_from_above(s, i)));
                }
            }
            if ends_by_event && state != SoleState::FREE {
                self.functions.push(Function::Normal(s));
                if state.mode != Mode::Sliding {
                    self.functions.push(Function::Friction(s));
                }
            }
            if let Some(turning) = sole.turning().filter(|_| state != SoleState::FREE) {
                if turning.holds_spin() || turning.holds_roll() {
                    self.functions.push(Function::Turning(s));
                }
                let spins = turning.torsional > 0.0 && !turning.holds_spin();
                let rolls = turning.rolling > 0.0 && !turning.holds_roll();
                self.functions.extend(spins.then_some(Function::Spin(s, 0.0)));
                self.functions.extend(rolls.then_some(Function::Roll(s, 0.0)));
            }
        }
        if now.may_contradict {
            self.functions.push(Function::Contradiction);
        }
    }

    /// Whether the step has the functions of the step before, and these depend on nothing but the evaluation.
    pub fn are_known(&self) -> bool {
        let depends = |f: &Function| !matches!(f, Function::Height(..) | Function::Normal(_) | Function::Friction(_));
        self.functions == self.before && !self.functions.iter().any(depends)
    }

    /// Number of functions of the step.
    pub fn len(&self) -> usize {
        self.functions.len()
    }

    /// Ignores the functions that are negative at the start of the step. Returns whether there are
    /// any. A vertex that slides backwards slower than `rest`, m/s, may do so up to that speed: it
    /// has just been selected to slip, from a speed of zero up to rounding, and another selection
    /// would only return it to rest.
    pub fn overlook(&mut self, start: &mut [f64], rest: f64) -> bool {
        for (i, (item, g)) in self.functions.iter_mut().zip(start).enumerate().filter(|(_, (_, g))| **g < 0.0) {
            match item {
                Function::Slide(_, _, allowed) | Function::Spin(_, allowed) | Function::Roll(_, allowed)
                    if *g > -rest =>
                {
                    *allowed = rest;
                    *g += rest;
                }
                _ => {
                    self.overlooked.push(i);
                    *g = 1.0;
                }
            }
        }
        !self.overlooked.is_empty()
    }

    /// Values at the present evaluation, into a slice of length [`len`](Self::len).
    pub fn fill(&self, now: &ContactInForce, out: &mut [f64]) {
        let (p, tol) = (now.problem, now.tolerances);
        // Both functions of a margin follow each other.
        let mut last = None;
        let mut margin_of = |s: usize| match last {
            Some((sole, margin)) if sole == s => margin,
            _ => last.insert((s, margin(p, now.states, s, now.solution))).1,
        };
        for (item, g) in self.functions.iter().zip(out.iter_mut()) {
            *g = match *item {
                Function::Height(s, i) => p.soles[s].vertices[i].height,
                Function::Band(s, i, depth) => {
                    let v = &p.soles[s].vertices[i];
                    (v.height + depth).min(v.velocity.z + tol.velocity)
                }
                Function::Surface(s, i, inside) => {
                    let height = p.soles[s].vertices[i].height;
                    penalty::SURFACE + if inside { -height } else { height }
                }
                Function::Normal(s) => margin_of(s).normal,
                Function::Friction(s) => margin_of(s).friction,
                Function::Slide(s, i, allowed) => {
                    p.soles[s].vertices[i].velocity.xy().dot(&now.directions[s][i]) + allowed
                }
                Function::Turning(s) => {
                    let moment = turning::moment(p, s, now.solution);
                    let [spin, roll] = p.soles[s].turning.margins(now.solution.normal[s][0], &moment);
                    spin.min(roll) / p.scale
                }
                Function::Spin(s, allowed) => p.soles[s].turning.velocity.z * now.turning[s].direction.z + allowed,
                Function::Roll(s, allowed) => {
                    p.soles[s].turning.velocity.xy().dot(&now.turning[s].direction.xy()) + allowed
                }
                Function::Touch(i) => now.touching.gap(i),
                Function::Contradiction => CONTRADICTED - greatest_contradiction(p, now.states, now.solution),
                Function::Border(s, i, _) => now.regions.map_or(f64::INFINITY, |regions| regions.border(s, i)),
            };
        }
        self.overlooked.iter().for_each(|&i| out[i] = 1.0);
    }

    /// If a sliding vertex crossed a border and returned within the step that ends at the present
    /// evaluation, returns the fraction of the step after which it is probably beyond the border.
    pub fn passed_over(&self, now: &ContactInForce, values: &[f64]) -> Option<f64> {
        let regions = now.regions?;
        let part = self.functions.iter().zip(values).filter_map(|(function, g)| match function {
            Function::Border(s, i, from) if *g >= 0.0 => regions.crossing(*s, *i, from),
            _ => None,
        });
        part.min_by(f64::total_cmp)
    }

    /// Marks the soles whose load reached its limit; some of `values` are negative.
    pub fn suspects(&self, values: &[f64], suspect: &mut PerSole<u8>) {
        suspect.fill(0);
        let fired =
            |kind: fn(&Function) -> bool| self.functions.iter().zip(values).any(|(item, g)| kind(item) && *g < 0.0);
        // Several soles may reach their limit together; rounding decides which of them fires.
        let normal = if fired(|i| matches!(i, Function::Normal(_))) { CLEAR } else { 0.0 };
        let friction = if fired(|i| matches!(i, Function::Friction(_))) { CLEAR } else { 0.0 };
        let turning = if fired(|i| matches!(i, Function::Turning(_))) { CLEAR } else { 0.0 };
        for (item, g) in self.functions.iter().zip(values) {
            match *item {
                Function::Normal(s) if *g < normal => suspect[s] |= SUSPECT_NORMAL,
                Function::Friction(s) if *g < friction => suspect[s] |= SUSPECT_FRICTION,
                Function::Turning(s) if *g < turning => suspect[s] |= SUSPECT_TURNING,
                _ => {}
            }
        }
    }
}

/// Whether an unclamped vertex in the tolerance band accelerates into the floor by more than a_t.
pub(crate) fn sinks(now: &ContactInForce) -> bool {
    let (p, tol) = (now.problem, now.tolerances);
    p.soles.iter().enumerate().any(|(s, sole)| {
        let k = sole.vertices.len();
        sole.vertices.iter().enumerate().any(|(i, v)| {
            !(now.is_imposed)(s)
                && !now.states[s].clamps(i, k)
                && v.is_in_band(tol)
                && p.vertex_motion(&now.solution.motion, s, i).z < -tol.acceleration
        })
    })
}
