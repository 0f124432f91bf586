//! Impacts of one body: nothing enters the floor, friction stays in its cone, energy never rises.

use super::rigid::{Rigid, body, rules, triple};
use nalgebra::Vector3;
use proptest::prelude::*;
use stiction::contact::candidate::Solution;
use stiction::contact::exact::Exact;
use stiction::contact::method::{Method, Question};
use stiction::contact::problem::{Level, Problem};
use stiction::contact::select::Selection;

/// Velocities before: of the centre of mass up to 2 m/s, downwards 0.2 to 2.2 m/s, turning up to 6 rad/s.
fn falling(body: &Rigid, velocity: &Vector3<f64>, spin: &Vector3<f64>) -> Problem {
    let mut p = body.problem(Level::Velocity, &Vector3::zeros(), &Vector3::zeros());
    let com = Vector3::new(2.0 * velocity.x, 2.0 * velocity.y, velocity.z - 1.2);
    let before = body.motion(&com, &(spin * 6.0));
    p.b.copy_from_slice(&before);
    for i in 0..body.sole.len() {
        p.soles[0].vertices[i].velocity = p.vertex_motion(&before, 0, i);
    }
    p
}

fn strike(p: &mut Problem) -> (Selection, Solution) {
    let (mut exact, mut out) = (Exact::new(p), Solution::new(p));
    let rules = rules();
    let question = Question { rules: &rules, event: true, allowed: &|_, _| true };
    let selection = exact.impulse(p, &question, &mut out);
    (selection, out)
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(11),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn an_impact_is_consistent_and_loses_energy(body in body(), velocity in triple(), spin in triple()) {
        let mut p = falling(&body, &velocity, &spin);
        let before = p.b.clone();
        let (selection, out) = strike(&mut p);
        prop_assert!(selection.consistent, "{:?}", selection.verdict.levels);
        // Rounding of the solve, some 1e-12 of the energy.
        let energy = body.energy(&before);
        prop_assert!(body.energy(&out.motion) <= energy * (1.0 + 1e-9), "{} {}", body.energy(&out.motion), energy);
        for i in 0..body.sole.len() {
            prop_assert!(p.vertex_motion(&out.motion, 0, i).z > -1e-8, "enters the floor");
            let (n, t) = (out.normal[0][i], out.tangent[0][i]);
            prop_assert!(n >= -1e-9 * body.mass);
            if selection.states[0].is_dynamic() {
                prop_assert!(t.norm() <= body.mu[0] * n.max(0.0) + 1e-9 * body.mass);
            }
        }
    }

    #[test]
    fn without_friction_restitution_returns_its_square(
        body in body(), velocity in triple(), spin in triple(), e in 0.0..1.0f64
    ) {
        let body = Rigid { mu: [0.0; 2], ..body };
        let mut p = falling(&body, &velocity, &spin);
        let before = p.b.clone();
        p.soles[0].target = Vector3::new(before[2], before[3], before[4]) * -e;
        let (selection, out) = strike(&mut p);
        let energy = body.energy(&before);
        prop_assert!(body.energy(&out.motion) <= energy * (1.0 + 1e-9));
        // Impulses are normal, so nothing changes the tangential momentum.
        let (after, com) = (&out.motion, body.motion(&Vector3::zeros(), &Vector3::new(out.motion[3], out.motion[4], out.motion[5])));
        let was = body.motion(&Vector3::zeros(), &Vector3::new(before[3], before[4], before[5]));
        for axis in 0..2 {
            prop_assert!((after[axis] - com[axis] - (before[axis] - was[axis])).abs() < 1e-9);
        }
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states[0], selection.verdict.levels);
    }
}
