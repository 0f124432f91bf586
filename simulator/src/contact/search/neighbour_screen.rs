//! Excludes neighbours of a valid candidate without testing them.
//!
//! A neighbour differs from the candidate in the state of one sole s. With the states and sliding
//! directions of all other soles held, the motion of sole s depends on its wrench by
//!
//! ```text
//! m_s = m_0 + G w_s          G (6 x 6)
//! ```
//!
//! with m_0 its motion while it is free and G its response under the conditions of the other soles.
//! A state of sole s adds unknowns and conditions ([`candidate`](super::candidate)):
//!
//! ```text
//! w_s = B x        R G B x = target - R (m_0 + c)
//! ```
//!
//! at most six, so that every neighbour costs one small solve. It is excluded if the floor pulls at
//! a vertex or an unclamped vertex of the sole violates Signorini's condition by more than rounding:
//! then the neighbour is not valid, and a candidate that is valid stays the better one. Vertices
//! without velocity slide in the direction that they have in the candidate; sliding faces, whose
//! pressure is shared by a rule, are not excluded.

use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::judge::{CLEAR, Rules, greatest_speed, unclamped_violation};
use crate::contact::search::static_loads::edge_load;
use crate::linalg::linear::Linear;
use nalgebra::Vector3;

/// Condensed problem of one sole, with its scratch.
#[derive(Clone, Debug)]
pub struct NeighbourScreen {
    sole: usize,
    /// m_0 and the columns of G.
    free: [f64; 6],
    response: [[f64; 6]; 6],
    motion: Vec<f64>,
    out: Solution,
    linear: Linear,
}

impl NeighbourScreen {
    /// For problems of this size.
    pub fn new(p: &Problem) -> Self {
        NeighbourScreen {
            sole: 0,
            free: [0.0; 6],
            response: [[0.0; 6]; 6],
            motion: vec![0.0; p.dim()],
            out: Solution::new(p),
            linear: Linear::new(6),
        }
    }

    /// Condenses the problem to sole `s`, with the directions that `states` have left in it.
    pub fn condense(&mut self, solver: &mut CandidateSolver, p: &Problem, states: &States, s: usize) {
        let mut others = states.clone();
        others[s] = SoleState::FREE;
        solver.solve(p, &others, &mut self.out);
        self.sole = s;
        self.free.copy_from_slice(&self.out.motion[6 * s..6 * s + 6]);
        for (axis, column) in self.response.iter_mut().enumerate() {
            let mut unit = [0.0; 6];
            unit[axis] = 1.0;
            solver.response(p, s, &unit, &mut self.motion);
            column.copy_from_slice(&self.motion[6 * s..6 * s + 6]);
        }
    }

    /// Whether the condensed sole in `state` violates Signorini's condition.
    pub fn excludes(&mut self, solver: &mut CandidateSolver, p: &Problem, state: SoleState, rules: &Rules) -> bool {
        let s = self.sole;
        let sole = &p.soles[s];
        let k = sole.vertices.len();
        if state.pattern == Pattern::Face {
            return false;
        }
        let (columns, rows) = solver.terms(p, s, state);
        let n = columns.len();
        let (mut a, mut x) = ([0.0; 36], [0.0; 6]);
        let mut moved = [[0.0; 6]; 6];
        for (moved, (_, b)) in moved.iter_mut().zip(columns) {
            let mut unit = [0.0; 6];
            b.add_to(1.0, &mut unit);
            for (column, size) in self.response.iter().zip(unit) {
                moved.iter_mut().zip(column).for_each(|(m, g)| *m += g * size);
            }
        }
        for (r, (_, row, target)) in rows.iter().enumerate() {
            x[r] = target - row.dot(&self.free);
            (0..n).for_each(|c| a[r * n + c] = row.dot(&moved[c]));
        }
        if n > 0 && self.linear.solve(&mut a[..n * n], &mut x[..n]) < n {
            return false;
        }
        let (mut wrench, mut motion) = ([0.0; 6], self.free);
        for ((x, (_, b)), moved) in x.iter().zip(columns).zip(&moved) {
            b.add_to(*x, &mut wrench);
            motion.iter_mut().zip(moved).for_each(|(m, g)| *m += g * x);
        }
        let pulls = |n: f64| n < -CLEAR * p.scale;
        let normal = match (state.pattern, state.is_static()) {
            (Pattern::Vertex(_), true) => [wrench[2], 0.0],
            (Pattern::Edge(i), true) => edge_load(sole, i as usize, (i as usize + 1) % k, &wrench).0,
            (Pattern::Edge(_), false) => [x[0], x[1]],
            (Pattern::Vertex(_), false) => [x[0], 0.0],
            _ => [0.0; 2],
        };
        if normal.into_iter().any(pulls) {
            return true;
        }
        let scale = greatest_speed(p);
        let drive = match p.level {
            Level::Acceleration => p.b[6 * s..6 * s + 3].iter().map(|b| b.abs()).fold(0.0, f64::max),
            Level::Velocity => scale,
        };
        let (linear, angular) = (Vector3::from_column_slice(&motion[..3]), Vector3::from_column_slice(&motion[3..]));
        (0..k).filter(|&i| !state.clamps(i, k)).any(|i| {
            let v = &sole.vertices[i];
            let up = (linear + angular.cross(&v.r) + v.bias).z;
            unclamped_violation(p, s, i, up + CLEAR * drive, scale, rules).1 > 0.0
        })
    }
}
