//! Impacts of one body: nothing enters the floor, friction stays in its cone, energy never rises.

use super::law;
use super::rigid::{Rigid, body_on, rules, triple};
use nalgebra::{Matrix3, Vector2, Vector3};
use proptest::prelude::*;
use stiction::contact::methods::contact_method::{ContactSolver, SelectionInput};
use stiction::contact::methods::exact::{Exact, ExactParameters};
use stiction::contact::model::problem::{Level, Problem};
use stiction::contact::model::solution::Solution;
use stiction::contact::search::select::{SearchOrder, Selection};

/// Velocities before the impact: of the centre of mass up to 2 m/s, downwards 0.2 to 2.2 m/s,
/// turning up to 6 rad/s.
pub fn falling(body: &Rigid, velocity: &Vector3<f64>, spin: &Vector3<f64>) -> Problem {
    let mut p = body.problem(Level::Velocity, &Vector3::zeros(), &Vector3::zeros());
    let com = Vector3::new(2.0 * velocity.x, 2.0 * velocity.y, velocity.z - 1.2);
    let before = body.motion(&com, &(spin * 6.0));
    p.b.copy_from_slice(&before);
    for i in 0..body.sole.len() {
        p.soles[0].vertices[i].velocity = p.vertex_motion(&before, 0, i);
    }
    p
}

pub fn strike(p: &mut Problem) -> (Selection, Solution) {
    strike_with(SearchOrder::Direct, p)
}

/// The same with an order of search.
pub fn strike_with(search: SearchOrder, p: &mut Problem) -> (Selection, Solution) {
    let (mut exact, mut out) = (Exact::new(ExactParameters { search }, p), Solution::new(p));
    let rules = rules();
    let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true, cancel: None };
    let selection = exact.impulse(p, &input, &mut out);
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
    fn an_impact_is_consistent_and_loses_energy(body in body_on(1, 8), velocity in triple(), spin in triple()) {
        let mut p = falling(&body, &velocity, &spin);
        let before = p.b.clone();
        let (selection, out) = strike(&mut p);
        prop_assert!(selection.consistent, "{:?}", selection.assessment.levels);
        // Rounding of the solve, some 1e-12 of the energy.
        let energy = body.energy(&before);
        prop_assert!(body.energy(&out.motion) <= energy * (1.0 + 1e-9), "{} {}", body.energy(&out.motion), energy);
        let violations = law::violations(&p, &selection.states, &out, before.iter().map(|b| b.abs()).fold(1.0, f64::max));
        prop_assert!(violations.is_empty(), "{:?} {violations:?}", selection.states[0]);
    }

    #[test]
    fn an_impact_with_restitution_obeys_the_law_and_gains_at_most_its_normal_work(
        body in body_on(1, 8), velocity in triple(), spin in triple(), e in 0.0..1.0f64
    ) {
        let mut p = falling(&body, &velocity, &spin);
        let before = p.b.clone();
        p.soles[0].target = Vector3::new(before[2], before[3], before[4]) * -e;
        let (selection, out) = strike(&mut p);
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states[0], selection.assessment.levels);
        let violations = law::violations(&p, &selection.states, &out, before.iter().map(|b| b.abs()).fold(1.0, f64::max));
        prop_assert!(violations.is_empty(), "{:?} {violations:?}", selection.states[0]);
        // dE = p . (v+ + v-) / 2 = p . v+ - p . W p / 2 <= p . v+, and of that only the normal part
        // can be positive.
        let back: f64 = (0..body.sole.len()).map(|i| out.normal[0][i] * p.vertex_motion(&out.motion, 0, i).z).sum();
        let gain = body.energy(&out.motion) - body.energy(&before);
        prop_assert!(gain <= back.max(0.0) + 1e-9 * body.energy(&before), "{gain} {back}");
    }

    #[test]
    fn without_friction_the_energy_falls_to_the_square_of_restitution(
        body in body_on(1, 8), velocity in triple(), spin in triple(), e in 0.0..1.0f64
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
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states[0], selection.assessment.levels);
    }
}

/// Known limit of Newton's restitution with friction (Kane and Levinson): a point that sticks in
/// the impact, with its body leaning over it, returns `-e v_n` whatever friction does, and the
/// energy can rise.
#[test]
fn restitution_with_sticking_friction_can_raise_the_energy() {
    let body = Rigid {
        sole: vec![Vector2::zeros()],
        mass: 1.0,
        inertia: Matrix3::identity() * 0.01,
        com: Vector3::new(0.1, 0.0, 0.1),
        mu: [1.0; 2],
    };
    // The point falls at 1 m/s and slips at 0.5 m/s; the impact alone would reverse its slip.
    let slip = 0.5;
    let gain = |e: f64| {
        let mut p = body.problem(Level::Velocity, &Vector3::zeros(), &Vector3::zeros());
        (p.b[0], p.b[2], p.soles[0].target.x) = (slip, -1.0, e);
        p.soles[0].vertices[0].velocity = Vector3::new(slip, 0.0, -1.0);
        let before = p.b.clone();
        let (selection, out) = strike(&mut p);
        assert!(selection.consistent && selection.states[0].is_static());
        body.energy(&out.motion) - body.energy(&before)
    };
    for e in [0.0, 0.5, 1.0] {
        // In the plane W = ((2, -1), (-1, 2)) / kg; the impulse W^-1 (-slip, 1 + e) does the work p
        // . (v+ + v-) / 2.
        let (x, z) = ((1.0 + e - 2.0 * slip) / 3.0, (2.0 * (1.0 + e) - slip) / 3.0);
        let closed = 0.5 * (x * slip + z * (e - 1.0));
        assert!((gain(e) - closed).abs() < 1e-14, "{e} {} {closed}", gain(e));
    }
    assert!(gain(0.0) < 0.0 && gain(1.0) > 0.08);
}
