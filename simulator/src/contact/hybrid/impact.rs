//! The impact law: velocity jumps at touch-down, and when a newly selected state stops motion.
//!
//! ```text
//! v+ = v + W p,        N >= 0,    v+_n - target >= 0,    N . (v+_n - target) = 0,    t in the friction cone of N
//! target = -e v_n      with e > 0 only where the sole approaches faster than v_t
//! ```
//!
//! p are the simultaneous impulses of all soles, N and t their normal and tangential parts per
//! vertex. These are Signorini's condition and Coulomb's law with velocities after the impact in
//! place of accelerations (`docs/contact.md`, section 6). The target is Newton's restitution of the
//! whole sole, so that a sole that lands flat stays parallel to the floor.

use crate::contact::model::problem::{Level, Problem, SoleProblem, TOUCHING, Tolerances};
use crate::contact::model::state::{SoleState, States};
use nalgebra::{Vector2, Vector3};

/// Depth, in distance tolerances, down to which a vertex can arrive at the floor: a vertex that lets go
/// where it was clamped may be 1e-8 m deep, and be driven back by another that stops.
const REACH: f64 = 1000.0;

/// Whether an unclamped vertex touches the floor and approaches it, or is within d of the floor and
/// approaches it faster than v_t. Soles with imposed states have no impacts.
pub(crate) fn is_due(p: &Problem, states: &States, tol: &Tolerances, is_imposed: impl Fn(usize) -> bool) -> bool {
    p.soles.iter().enumerate().any(|(s, sole)| {
        let k = sole.vertices.len();
        let approaches = |i: usize| {
            let v = &sole.vertices[i];
            !v.leaves
                && (v.is_near(tol) && v.velocity.z < -tol.velocity - tol.rest
                    || v.height <= TOUCHING && v.height >= -REACH * tol.distance && v.velocity.z < -tol.rest)
        };
        !is_imposed(s) && (0..k).any(|i| !states[s].clamps(i, k) && approaches(i))
    })
}

/// Sets the problem of an impact. `velocity` are the motions of the soles before it (6F),
/// `restitution` is e. Returns the greatest approach speed, m/s.
pub(crate) fn set_impact(p: &mut Problem, velocity: &[f64], tol: &Tolerances, restitution: f64) -> f64 {
    p.level = Level::Velocity;
    p.b.copy_from_slice(velocity);
    let mut fastest: f64 = 0.0;
    for (s, sole) in p.soles.iter_mut().enumerate() {
        (sole.turning.bias, sole.turning.spins, sole.turning.rolls) = (Vector3::zeros(), false, false);
        let mut approach: f64 = 0.0;
        for v in &mut sole.vertices {
            v.bias = Vector3::zeros();
            v.moving = false;
            v.direction = Vector2::zeros();
            v.near = v.is_near(tol);
            if v.near {
                approach = approach.max(-v.velocity.z);
            }
        }
        let near = sole.clampable(tol);
        sole.vertices.iter_mut().enumerate().for_each(|(i, v)| v.near = near >> i & 1 == 1);
        fastest = fastest.max(approach);
        set_target(sole, &velocity[6 * s..6 * s + 6], approach, tol, restitution);
    }
    fastest
}

/// Sets the problem that brings the clamped directions of newly selected states to rest. Returns
/// the states to solve it with. A sole about to slip from rest is held, so that it loses the
/// remainder of its old motion; otherwise friction would oppose that motion.
pub(crate) fn set_rest(
    p: &mut Problem,
    velocity: &[f64],
    states: &States,
    tol: &Tolerances,
    restitution: f64,
) -> States {
    p.level = Level::Velocity;
    p.b.copy_from_slice(velocity);
    for (s, sole) in p.soles.iter_mut().enumerate() {
        let approach = sole.vertices.iter().map(|v| -v.velocity.z).fold(0.0, f64::max);
        set_target(sole, &velocity[6 * s..6 * s + 6], approach, tol, restitution);
        sole.vertices.iter_mut().for_each(|v| v.bias = Vector3::zeros());
        sole.turning.bias = Vector3::zeros();
    }
    let mut held = states.clone();
    for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| states[*s].is_dynamic()) {
        let k = sole.vertices.len();
        let rests = |i: usize| sole.vertices[i].velocity.xy().norm() <= 10.0 * tol.rest;
        if (0..k).all(|i| !states[s].clamps(i, k) || rests(i)) {
            held[s] = SoleState::fixed(held[s].pattern);
        }
    }
    held
}

/// Normal velocity after = -e times before, on the whole sole; at rest speeds the impact is
/// plastic.
fn set_target(sole: &mut SoleProblem, velocity: &[f64], approach: f64, tol: &Tolerances, restitution: f64) {
    let e = if approach > tol.velocity { restitution } else { 0.0 };
    sole.target = Vector3::new(velocity[2], velocity[3], velocity[4]) * -e;
}

/// Greatest change of a vertex's velocity by the motions `after` (6F), m/s.
pub(crate) fn greatest_change(p: &Problem, after: &[f64]) -> f64 {
    let change = |(s, i)| (p.vertex_motion(after, s, i) - p.soles[s].vertices[i].velocity).norm();
    p.vertex_indices().map(change).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_that_let_go_below_the_floor_can_arrive_again() {
        let tol = Tolerances { distance: 1e-10, velocity: 0.02, acceleration: 1e-3, rest: 1e-7 };
        let mut p = Problem::new(&[1]);
        let mut due = |height: f64, speed: f64| {
            let v = &mut p.soles[0].vertices[0];
            (v.height, v.velocity) = (height, Vector3::new(0.7, 0.0, speed));
            is_due(&p, &States::default(), &tol, |_| false)
        };
        // A foot of ANYmal, driven back by another that stopped.
        assert!(due(-1.3e-8, -3e-4));
        assert!(!due(-1.3e-8, 3e-4) && !due(1e-6, -3e-4));
        // Far below, a slow vertex is not one that arrives.
        assert!(!due(-1e-6, -3e-4) && due(-1e-6, -0.03));
    }
}
