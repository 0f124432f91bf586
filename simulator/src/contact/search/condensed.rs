//! The contact problem of the sliding soles alone, with the conditions of the static ones.
//!
//! A search for sliding directions ([`super::sliding_directions`]) solves one candidate many times,
//! and only the friction of its sliding soles differs. With the static soles held, their motion is
//!
//! ```text
//! m = b' + W' w          b' = b + W B x_0,   R W B x_0 = target - R (b + c)
//!                        W' = W + W B X,     R W B X = -R W
//! ```
//!
//! B and R are unknowns and conditions of the static soles ([`super::candidate`]), w the wrenches on the
//! sliding ones. With `W'` and `b'` in the places of W and b, and the static soles free, the same solver gives
//! the same motions from a smaller system.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::candidate::CandidateSolver;

/// Response, relative to that without static soles, below which these prevent a motion.
const PREVENTED: f64 = 1e-12;

/// W' and b', or W and b while the problem has those.
#[derive(Clone, Debug, Default)]
pub struct Condensed {
    w: Vec<f64>,
    b: Vec<f64>,
    motion: Vec<f64>,
    /// The sliding soles, and the static ones.
    pub loose: States,
    held: States,
}

impl Condensed {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        let n = p.dim();
        Condensed {
            w: vec![0.0; n * n],
            b: vec![0.0; n],
            motion: vec![0.0; n],
            loose: States::default(),
            held: States::default(),
        }
    }

    /// Computes W' and b' of the sliding soles. Returns false, without a result, if no sole is static.
    pub fn condense(&mut self, solver: &mut CandidateSolver, p: &Problem, states: &States, out: &mut Solution) -> bool {
        let soles = 0..p.soles.len();
        let is_held = |s: usize| states[s].is_static() && states[s] != SoleState::FREE;
        if !soles.clone().any(is_held) {
            return false;
        }
        self.loose.clone_from(states);
        self.held.clone_from(states);
        for s in soles.clone() {
            if states[s].is_dynamic() { self.held[s] = SoleState::FREE } else { self.loose[s] = SoleState::FREE }
        }
        let n = p.dim();
        solver.solve(p, &self.held, out);
        self.b.copy_from_slice(&out.motion);
        self.w.fill(0.0);
        for i in soles.filter(|s| states[*s].is_dynamic()).flat_map(|s| 6 * s..6 * s + 6) {
            let mut unit = [0.0; 6];
            unit[i % 6] = 1.0;
            solver.response(p, i / 6, &unit, &mut self.motion);
            // W' is symmetric.
            let row = &mut self.w[i * n..(i + 1) * n];
            for (j, (w, response)) in row.iter_mut().zip(&self.motion).enumerate() {
                let size = (p.w[i * n + i] * p.w[j * n + j]).sqrt();
                *w = if response.abs() > PREVENTED * size { *response } else { 0.0 };
            }
        }
        true
    }

    /// Exchanges W' and b' with W and b of the problem.
    pub fn exchange(&mut self, p: &mut Problem) {
        std::mem::swap(&mut self.w, &mut p.w);
        std::mem::swap(&mut self.b, &mut p.b);
    }
}
