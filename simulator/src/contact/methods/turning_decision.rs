//! Decisions of the one-step method about torsional and rolling friction of point contacts.
//!
//! A held component of the angular velocity stays held while its last moment is within its limit, and then
//! gives way along that moment. A turning one turns on until its velocity has reversed or vanished. At a landing
//! what is slower than v_t at a lever of a metre is held.

use crate::contact::model::problem::{Problem, Tolerances};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::SoleState;
use crate::contact::model::turning::moment;
use nalgebra::Vector3;

/// Decides for contact `s`, which was in state `before` with the load `last` and is in `state` now.
pub fn decide(p: &mut Problem, s: usize, [before, state]: [SoleState; 2], last: &Solution, tol: &Tolerances) {
    let Some(turning) = p.soles[s].turning().filter(|_| state != SoleState::FREE) else { return };
    let (mut mode, omega) = (turning.mode, turning.velocity);
    let lands = before == SoleState::FREE;
    let tau = moment(p, s, last);
    let [spin_margin, roll_margin] = turning.margins(last.normal[s][0].max(0.0), &tau);
    let turns = |holds: bool, speed: f64, along: f64, margin: f64| match holds {
        _ if lands => (speed > tol.velocity).then_some(true),
        true => (margin < 0.0).then_some(false),
        false => (speed > tol.rest && along > 0.0).then_some(true),
    };
    // True: along the velocity, false: against the moment.
    let spin = turns(mode.holds_spin, omega.z.abs(), omega.z * mode.direction.z, spin_margin);
    let t = omega.xy();
    let roll = turns(mode.holds_roll, t.norm(), t.dot(&mode.direction.xy()), roll_margin);
    (mode.holds_spin, mode.holds_roll) = (spin.is_none(), roll.is_none());
    let sign = spin.map_or(0.0, |moves| if moves { omega.z.signum() } else { -tau.z.signum() });
    let along = roll.map(|moves| if moves { t } else { -tau.xy() });
    let along = along.and_then(|along| along.try_normalize(0.0)).unwrap_or_default();
    mode.direction = Vector3::new(along.x, along.y, sign);
    p.soles[s].turning.mode = mode;
}
