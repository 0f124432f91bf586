//! Finds which angular motions of point contacts torsional and rolling friction hold.
//!
//! The modes of [`crate::contact::model::turning`] are no states of the search: each candidate has its own. They
//! start with everything at rest held. A moment beyond its limit lets go, in the direction in which it gave way;
//! one that drives the motion it should oppose holds again. For given normal forces the moments of least
//! complementary energy are unique, and this active-set iteration ends at them.
//!
//! The direction u of a rolling motion that starts from rest is that of the resulting motion r(u), an angle:
//!
//! ```text
//! f(theta) = u x r = 0,    u . r > 0         f' = -(u . r) - mu_r N  u' . R u'       u' = z x u
//! ```
//!
//! R is the response of the angular motion to a moment under the candidate's conditions, so that f falls where
//! u . r > 0, and Newton's method converges.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::model::turning::{self, TurningFault};
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::judge::{CLEAR, Rules, SUSPECT_TURNING};
use crate::math;
use nalgebra::Vector2;

/// Greatest number of solves of a candidate.
const ROUNDS: usize = 64;

/// Times that a contact may hold again before its modes are left as they are: the candidate then fails.
const RETURNS: usize = 4;

/// Starts the modes of a candidate: components that move turn, all others are held.
pub(super) fn begin(p: &mut Problem) {
    p.soles.iter_mut().for_each(|sole| sole.turning.begin());
}

/// The first fault of the mode of contact `s` under these rules.
pub(super) fn fault(p: &Problem, s: usize, solution: &Solution, rules: &Rules) -> Option<TurningFault> {
    let margins = [-rules.rounding * p.scale, CLEAR * p.scale];
    turning::fault(p, s, solution, rules.suspect(p, s) & SUSPECT_TURNING != 0, margins)
}

/// Progress of the iteration for one candidate.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounds {
    rounds: usize,
    returns: usize,
}

impl Rounds {
    /// Changes modes after a solve of the candidate. Returns whether it must be solved again.
    pub fn update(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        rules: &Rules,
        out: &Solution,
        motion: &mut [f64],
    ) -> bool {
        self.rounds += 1;
        if self.rounds > ROUNDS || self.returns > RETURNS * p.soles.len() {
            return false;
        }
        let mut changed = false;
        for s in 0..p.soles.len() {
            if p.soles[s].turning().is_none() || states[s].normal_rows() == 0 || !(out.normal[s][0] > 0.0) {
                continue;
            }
            let Some(fault) = fault(p, s, out, rules) else { continue };
            changed = true;
            let tau = turning::moment(p, s, out);
            let turn = match fault {
                TurningFault::Direction(sine, cosine) if cosine > 0.0 || self.rounds < ROUNDS / 2 => {
                    newton_angle(solver, p, s, out.normal[s][0], [sine, cosine], motion)
                }
                _ => 0.0,
            };
            let mode = &mut p.soles[s].turning.mode;
            match fault {
                TurningFault::Spin => (mode.holds_spin, mode.direction.z) = (false, -tau.z.signum()),
                TurningFault::Roll => {
                    let t = -tau.xy().normalize();
                    mode.holds_roll = false;
                    (mode.direction.x, mode.direction.y) = (t.x, t.y);
                }
                TurningFault::DrivenSpin => {
                    (mode.holds_spin, mode.direction.z) = (true, 0.0);
                    self.returns += 1;
                }
                TurningFault::Direction(..) if turn != 0.0 => {
                    let (sin, cos) = math::sin_cos(turn);
                    let d = mode.direction.xy();
                    (mode.direction.x, mode.direction.y) = (cos * d.x - sin * d.y, sin * d.x + cos * d.y);
                }
                TurningFault::Direction(..) => {
                    (mode.holds_roll, mode.direction.x, mode.direction.y) = (true, 0.0, 0.0);
                    self.returns += 1;
                }
            }
        }
        changed
    }
}

/// Step of Newton's method for the angle of the rolling direction of contact `s`, at most a quarter turn.
fn newton_angle(
    solver: &mut CandidateSolver,
    p: &Problem,
    s: usize,
    normal: f64,
    [sine, cosine]: [f64; 2],
    motion: &mut [f64],
) -> f64 {
    let turning = &p.soles[s].turning;
    let d = turning.mode.direction.xy();
    let across = Vector2::new(-d.y, d.x);
    solver.response(p, s, &[0.0, 0.0, 0.0, across.x, across.y, 0.0], motion);
    let response = across.x * motion[6 * s + 3] + across.y * motion[6 * s + 4];
    let slope = cosine + turning.rolling * normal * response;
    if slope > 0.0 { (sine / slope).clamp(-1.5, 1.5) } else { sine.signum() * 1.5 }
}
