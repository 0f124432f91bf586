//! Two soles at once: on two bodies with various joints, or on one body.

use super::impact::{strike, strike_with};
use super::law;
use super::pair::{JOINTS, Joint, Pair, pair};
use super::rest::{pressed, select, select_with};
use super::rigid::{G, rules, triple};
use nalgebra::Vector3;
use proptest::prelude::*;
use stiction::contact::model::problem::{Level, Problem};
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::{SoleState, States};
use stiction::contact::search::select::{SearchOrder, Selector};

fn loaded(pair: &Pair, force: &[Vector3<f64>; 2], moment: &[Vector3<f64>; 2]) -> Problem {
    let loads = [0, 1].map(|i| pressed(&pair.bodies[i], &force[i], &moment[i]));
    pair.problem(Level::Acceleration, &loads)
}

/// Velocities before an impact: up to 2 m/s, downwards 0.2 to 2.2 m/s, turning up to 6 rad/s,
/// projected onto the joint.
fn falling(pair: &Pair, velocity: &[Vector3<f64>; 2], spin: &[Vector3<f64>; 2]) -> Problem {
    let com = velocity.map(|v| Vector3::new(2.0 * v.x, 2.0 * v.y, v.z - 1.2));
    pair.falling(&com, &spin.map(|s| s * 6.0))
}

fn size(p: &Problem, least: f64) -> f64 {
    p.b.iter().map(|b| b.abs()).fold(least, f64::max)
}

/// Greatest difference of the motions of a pair and of the pair in opposite order.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    (0..12).map(|i| (a[i] - b[(i + 6) % 12]).abs()).fold(0.0, f64::max)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn back<T: Copy>([a, b]: [T; 2]) -> [T; 2] {
    [b, a]
}

/// Joints that leave all normal directions of both soles independent: no indeterminate load
/// sharing.
const LOOSE: &[Joint] = &[Joint::Apart, Joint::Rod];

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(6),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn the_state_of_two_soles_under_any_load_obeys_the_law(
        pair in pair(JOINTS), force in [triple(), triple()], moment in [triple(), triple()]
    ) {
        let mut p = loaded(&pair, &force, &moment);
        let (selection, out) = select(&mut p);
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states, selection.assessment.levels);
        let violations = law::violations(&p, &selection.states, &out, size(&p, G));
        prop_assert!(violations.is_empty(), "{:?} {violations:?}", selection.states);
    }

    #[test]
    fn the_order_of_the_soles_does_not_matter(
        pair in pair(LOOSE), force in [triple(), triple()], moment in [triple(), triple()]
    ) {
        let (mut p, mut q) = (loaded(&pair, &force, &moment), loaded(&pair.swapped(), &back(force), &back(moment)));
        let ((a, x), (b, y)) = (select(&mut p), select(&mut q));
        prop_assert_eq!((a.states[0].rows(), a.states[1].rows()), (b.states[1].rows(), b.states[0].rows()));
        // Sliding directions are found to 1e-10 of the motion without friction.
        prop_assert!(apart(&x.motion, &y.motion) < 1e-7 * size(&p, G), "{}", apart(&x.motion, &y.motion));
    }

    #[test]
    fn a_plastic_impact_of_two_soles_obeys_the_law_and_loses_energy(
        pair in pair(JOINTS), velocity in [triple(), triple()], spin in [triple(), triple()]
    ) {
        let mut p = falling(&pair, &velocity, &spin);
        let before = p.b.clone();
        let (selection, out) = strike(&mut p);
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states, selection.assessment.levels);
        let violations = law::violations(&p, &selection.states, &out, size(&p, 1.0));
        prop_assert!(violations.is_empty(), "{:?} {violations:?}", selection.states);
        // Rounding of the solve, some 1e-12 of the energy, times the condition of the joint.
        prop_assert!(pair.energy(&out.motion) <= pair.energy(&before) * (1.0 + 1e-9));
    }

    #[test]
    fn restitution_of_two_soles_gains_at_most_its_normal_work(
        pair in pair(LOOSE), velocity in [triple(), triple()], spin in [triple(), triple()], e in 0.0..1.0f64
    ) {
        let mut p = falling(&pair, &velocity, &spin);
        let before = p.b.clone();
        for s in 0..2 {
            p.soles[s].target = Vector3::new(before[6 * s + 2], before[6 * s + 3], before[6 * s + 4]) * -e;
        }
        let (selection, out) = strike(&mut p);
        prop_assert!(selection.consistent, "{:?} {:?}", selection.states, selection.assessment.levels);
        let violations = law::violations(&p, &selection.states, &out, size(&p, 1.0));
        prop_assert!(violations.is_empty(), "{:?} {violations:?}", selection.states);
        let work = |s: usize, i: usize| out.normal[s][i] * p.vertex_motion(&out.motion, s, i).z;
        let back: f64 = (0..2).flat_map(|s| (0..p.soles[s].vertices.len()).map(move |i| (s, i))).map(|(s, i)| work(s, i)).sum();
        let gain = pair.energy(&out.motion) - pair.energy(&before);
        prop_assert!(gain <= back.max(0.0) + 1e-9 * pair.energy(&before), "{gain} {back}");
    }
}

/// The motion of every valid state, if they are all the same.
fn unique_motion(p: &Problem, drive: f64) -> Option<Vec<f64>> {
    let (mut p, mut out) = (p.clone(), Solution::new(p));
    let mut selector = Selector::new(SearchOrder::Paper, &p);
    let [first, second] = [0, 1].map(|s| p.soles[s].vertices.len());
    let mut found: Option<Vec<f64>> = None;
    for (a, b) in SoleState::refined(first).flat_map(|a| SoleState::refined(second).map(move |b| (a, b))) {
        let mut states = States::default();
        (states[0], states[1]) = (a, b);
        if !selector.test(&mut p, &states, &rules(), &mut out).valid() {
            continue;
        }
        if found.as_ref().is_some_and(|motion| distance(motion, &out.motion) > 1e-7 * drive) {
            return None;
        }
        found.get_or_insert_with(|| out.motion.clone());
    }
    found
}

fn equal_friction(mut p: Problem) -> Problem {
    p.soles.iter_mut().flat_map(|sole| &mut sole.vertices).for_each(|v| v.mu_k = v.mu_s);
    p
}

proptest! {
    #![proptest_config(config(30))]

    #[test]
    fn both_searches_find_the_motion_where_it_is_unique(
        pair in pair(LOOSE), force in [triple(), triple()], moment in [triple(), triple()]
    ) {
        let p = equal_friction(loaded(&pair, &force, &moment));
        let drive = size(&p, G);
        let motion = unique_motion(&p, drive);
        prop_assume!(motion.is_some());
        for order in [SearchOrder::Direct, SearchOrder::Paper] {
            let (selection, out) = select_with(order, &mut p.clone());
            prop_assert!(selection.consistent, "{order:?}");
            // Sliding directions are found to 1e-10 of the motion without friction.
            let error = distance(&out.motion, motion.as_ref().unwrap());
            prop_assert!(error < 1e-7 * drive, "{order:?} {error:e}");
        }
    }

    #[test]
    fn both_searches_find_the_impact_where_it_is_unique(
        pair in pair(LOOSE), velocity in [triple(), triple()], spin in [triple(), triple()]
    ) {
        let p = equal_friction(falling(&pair, &velocity, &spin));
        let drive = size(&p, 1.0);
        let motion = unique_motion(&p, drive);
        prop_assume!(motion.is_some());
        for order in [SearchOrder::Direct, SearchOrder::Paper] {
            let (selection, out) = strike_with(order, &mut p.clone());
            prop_assert!(selection.consistent, "{order:?}");
            let error = distance(&out.motion, motion.as_ref().unwrap());
            prop_assert!(error < 1e-7 * drive, "{order:?} {error:e}");
        }
    }
}
