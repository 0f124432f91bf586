//! Compares the exact method with Pinocchio's ADMM contact solver on problems of real runs.
//!
//! `make_contact.py` records the problems: impacts, time steps, and soles at rest that hold or
//! begin to slip; `make_falls.py` those of falls onto links, terrain and boxes. The former documents
//! which problems are comparable and when their solution is unique. The test compares the resultant
//! wrench of each polygon.

use serde::Deserialize;
use std::collections::BTreeSet;
use stiction::contact::selection_record::{SelectionRecord, SelectionResult};

#[derive(Deserialize)]
struct Oracle {
    robot: String,
    problems: Vec<Problem>,
}

#[derive(Deserialize)]
struct Problem {
    run: String,
    number: usize,
    residual: f64,
    /// Sole wrenches by ADMM, 6F.
    wrench: Vec<f64>,
    selection: SelectionRecord,
}

fn oracles() -> [Oracle; 3] {
    [include_str!("contact_block.json"), include_str!("contact_hoap2.json"), include_str!("contact_falls.json")]
        .map(|text| serde_json::from_str(text).expect("a file of make_contact.py"))
}

/// Both solutions satisfy their conditions to 1e-12 of the scales. The error of slip directions of
/// the exact method dominates: 1e-10 of the frictionless motion. The greatest observed difference
/// was 3e-11 of soles on the floor.
const BOUND: f64 = 1e-8;

/// Of falls it was 1.02e-8, at an impact of three boxes of which two slide.
const BOUND_OF_FALLS: f64 = 2e-8;

/// Greatest distance between wrenches over the greatest force, moments over the soles' radii.
fn distance(problem: &Problem, answer: &SelectionResult) -> f64 {
    let length = |i: usize| if i % 6 < 3 { 1.0 } else { problem.selection.soles[i / 6].radius_m };
    let largest =
        |w: &mut dyn Iterator<Item = f64>| w.fold(0.0, |a: f64, x| if x.is_nan() { x } else { a.max(x.abs()) });
    let of = |w: &[f64]| largest(&mut w.iter().enumerate().map(|(i, x)| x / length(i)));
    let difference: Vec<f64> = answer.wrench.iter().zip(&problem.wrench).map(|(a, b)| a - b).collect();
    assert_eq!(answer.wrench.len(), problem.wrench.len());
    let (difference, scale) = (of(&difference), of(&problem.wrench));
    if scale > 0.0 { difference / scale } else { difference }
}

#[test]
fn wrenches_agree_with_an_independent_solver() {
    let (mut count, mut states, mut levels) = (0, BTreeSet::new(), BTreeSet::new());
    for oracle in oracles() {
        for problem in &oracle.problems {
            let name = format!("{} {} {}", oracle.robot, problem.run, problem.number);
            assert!(problem.residual <= 1e-12, "{name} was not solved");
            let answer = problem.selection.replay().unwrap_or_else(|e| panic!("{name}: {e}"));
            let distance = distance(problem, &answer);
            // This form of the comparison also fails for NaN.
            let bound = if oracle.robot == "falls" { BOUND_OF_FALLS } else { BOUND };
            assert!(distance <= bound, "{name}: {:?}, wrenches differ by {distance:e}", answer.states);
            assert!(answer.consistent, "{name}: {:?} violate {:?}", answer.states, answer.violations);
            count += 1;
            states.extend(answer.states.iter().map(|s| s.replace(|c: char| c.is_ascii_digit(), "_")));
            levels.insert(problem.selection.units.force.clone());
        }
    }
    assert!(count >= 40 && levels.len() == 2, "{count} problems at {levels:?}");
    let met = ["edge-_-dynamic", "face-dynamic", "face-static", "free", "vertex-_-dynamic", "vertex-_-static"];
    assert!(met.iter().all(|s| states.contains(*s)), "{states:?}");
}

/// The comparison detects an error of one part in ten thousand in the friction coefficient.
#[test]
fn a_small_error_of_friction_is_detected_in_every_sliding_problem() {
    let mut slides = 0;
    for problem in oracles().into_iter().flat_map(|o| o.problems) {
        let mut other = problem.selection.clone();
        other.soles.iter_mut().flat_map(|s| &mut s.vertices).for_each(|v| {
            v.mu_s *= 1.0 - 1e-4;
            v.mu_k *= 1.0 - 1e-4;
        });
        let answer = other.replay().expect("it was replayed before");
        if answer.states.iter().any(|s| s.contains("dynamic")) {
            slides += 1;
            assert!(distance(&problem, &answer) > BOUND, "{} {}", problem.run, problem.number);
        }
    }
    assert!(slides > 20, "{slides}");
}
