//! Contact problems of robots thrown off their feet, recorded in runs of
//! `scenarios/studies/hard_pushes.py` (Talos, Romeo, ANYmal) and `hard-pushes.toml` (CB-i).
//!
//! In each of them the alternating directions do not converge, or the pressure rule of a face
//! excludes the pattern that the vertices as points suggest, or impulses are tiny. The search through
//! all states needed 10 to 4600 candidates for them, once without success.

use nalgebra::Vector2;
use serde::Deserialize;
use stiction::contact::methods::registry::MethodDescriptor;
use stiction::contact::model::problem::{Level, Problem};
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::{Pattern, SoleState, States};
use stiction::contact::search::candidate::CandidateSolver;
use stiction::contact::search::condensed::Condensed;
use stiction::contact::search::point_forces::PointForces;
use stiction::contact::selection_record::{SelectionRecord, SelectionResult};

#[derive(Deserialize)]
struct Recorded {
    run: String,
    selection: SelectionRecord,
}

fn recorded() -> Vec<Recorded> {
    serde_json::from_str(include_str!("hard_problems.json")).expect("a list of problems")
}

/// Greatest violation of the laws of Signorini and Coulomb at the vertices, relative to the greatest
/// force and motion. Tangential forces of static soles are not determined by vertex.
fn violation(p: &Problem, answer: &SelectionResult) -> f64 {
    let load = answer.normal.iter().flatten().fold(0.0, |m: f64, n| m.max(n.abs()));
    let drive = p.vertex_indices().map(|(s, i)| p.vertex_motion(&p.b, s, i).norm()).fold(0.0, f64::max);
    let mut worst: f64 = 0.0;
    for (s, i) in p.vertex_indices() {
        let (v, sole) = (&p.soles[s].vertices[i], &answer.states[s]);
        let m = p.vertex_motion(&answer.motion, s, i);
        let (n, t) = (answer.normal[s][i], Vector2::from(answer.tangent[s][i]));
        let target = if p.level == Level::Velocity { p.soles[s].vertex_target(i) } else { 0.0 };
        let short = if v.near { (target - m.z) / drive } else { 0.0 };
        let product = n * (m.z - target) / (load * drive);
        worst = [-n / load, short, product.abs()].into_iter().fold(worst, f64::max);
        if sole.contains("static") || sole == "free" || n == 0.0 {
            continue;
        }
        let slip = if v.moving { v.velocity.xy() } else { m.xy() };
        let law = if !v.moving && slip.norm() < 1e-6 * drive {
            t.norm() - v.mu_s * n
        } else {
            (t + slip.normalize() * (v.mu_k * n)).norm()
        };
        worst = worst.max(law / load);
    }
    worst
}

#[test]
fn hard_problems_are_solved_with_few_candidates() {
    for Recorded { run, selection } in recorded() {
        let p = selection.problem().expect("it was written as a problem");
        let answer = selection.replay().expect("its method exists");
        assert!(answer.consistent, "{run}: {:?} violate {:?}", answer.states, answer.violations);
        assert!(answer.tested <= 40, "{run}: {} candidates", answer.tested);
        // Slip directions are found to 1e-10 of the frictionless motion; the impulses of some problems
        // are 1e-8 of the robot's momentum, to which their rounding is relative.
        let worst = violation(&p, &answer);
        assert!(worst < 1e-6, "{run}: {:?} violates the laws by {worst:e}", answer.states);
    }
}

/// Close to a jam the alternating directions do not converge, and visits to the points in turn do.
#[test]
fn fixed_steps_are_solved_with_vertices_as_points() {
    let mut count = 0;
    for Recorded { run, selection } in recorded() {
        let p = selection.problem().expect("it was written as a problem");
        if p.step == 0.0 {
            continue;
        }
        let few = p.vertex_indices().filter(|&(s, i)| p.soles[s].vertices[i].near).count() <= 4;
        let mut points = PointForces::new(&p);
        let residual = points.solve(&p, |s, i| p.soles[s].vertices[i].near);
        // Where two soles share a load over ten vertices, visits converge slowly.
        let bound = if few { 1e-9 } else { 1e-3 };
        assert!(residual <= bound, "{run}: {residual:e}");
        count += 1;
    }
    assert_eq!(count, 5);
}

/// The parts of a sole's carrying vertices are its edges between them and the vertices themselves.
#[test]
fn parts_of_a_loaded_face_are_edges_then_vertices() {
    let recorded = recorded();
    let edge = recorded.iter().find(|r| r.run == "talos-016-landing").expect("it is in the file");
    let p = edge.selection.problem().expect("it was written as a problem");
    let mut points = PointForces::new(&p);
    points.solve(&p, |_, _| true);
    let mut parts = Vec::new();
    points.parts(&p, 1, 0.0, 100, &mut parts);
    let edges = parts.iter().take_while(|state| matches!(state.pattern, Pattern::Edge(_))).count();
    let vertices = &parts[edges..];
    assert!(edges > 0 && vertices.iter().all(|state| matches!(state.pattern, Pattern::Vertex(_))), "{parts:?}");
    assert!(!parts.contains(&SoleState::FREE));
}

/// A problem of six soles of four vertices on a mechanism of 20 coordinates, with random numbers.
fn random_problem(seed: u64) -> Problem {
    let mut state = seed;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut p = Problem::new(&[4; 6]);
    p.level = Level::Velocity;
    let n = p.dim();
    let jacobian: Vec<f64> = (0..20 * n).map(|_| random()).collect();
    for r in 0..n {
        for c in 0..n {
            p.w[r * n + c] = (0..20).map(|k| jacobian[20 * r + k] * jacobian[20 * c + k]).sum();
        }
        p.b[r] = random() - if r % 6 == 2 { 2.0 } else { 0.0 };
    }
    for v in p.soles.iter_mut().flat_map(|sole| &mut sole.vertices) {
        v.r = nalgebra::Vector3::new(random(), random(), 0.0) * 0.2;
        (v.mu_s, v.mu_k, v.near) = (0.5, 0.5, true);
    }
    p
}

/// Points that are fewer than the numbers of many soles are solved with their own matrix.
#[test]
fn few_points_obey_the_laws() {
    for seed in 0..50 {
        let p = random_problem(seed);
        let mut points = PointForces::new(&p);
        let residual = points.solve(&p, |_, i| i == 0);
        assert!(residual < 1e-9, "{seed}: {residual:e}");
        let motion = points.motion(&p).to_vec();
        let forces: Vec<_> = points.forces().collect();
        assert_eq!(forces.len(), 6);
        let load = forces.iter().map(|(.., f)| f.norm()).fold(f64::MIN_POSITIVE, f64::max);
        for (s, i, f) in forces {
            let (v, m) = (&p.soles[s].vertices[i], p.vertex_motion(&motion, s, i));
            let slip = m.xy().try_normalize(1e-6).unwrap_or_default();
            let friction = f.xy() + slip * (v.mu_s * f.z);
            let excess = if slip.norm() > 0.0 { friction.norm() } else { f.xy().norm() - v.mu_s * f.z };
            // The residual, which the directions of slow slips magnify.
            assert!(f.z >= 0.0 && m.z > -1e-8 * load && f.z * m.z < 1e-8 * load * load, "{seed}: {f} {m}");
            assert!(excess < 1e-3 * load, "{seed}: {f} {m}");
        }
    }
}

/// The sliding soles of a problem condensed by its static ones move as in the whole.
#[test]
fn condensed_problems_have_the_motions_of_the_whole() {
    let mut count = 0;
    for Recorded { run, selection } in recorded() {
        let mut p = selection.problem().expect("it was written as a problem");
        for (i, v) in p.soles.iter_mut().flat_map(|sole| &mut sole.vertices).enumerate() {
            v.direction = Vector2::new((i as f64).cos(), (i as f64).sin());
        }
        if p.soles.len() < 2 || p.soles.iter().any(|sole| sole.vertices.len() < 3) {
            continue;
        }
        for held in [Pattern::Face, Pattern::Edge(1), Pattern::Vertex(2)] {
            let mut states = States::default();
            states[0] = SoleState::fixed(held);
            states[1] = SoleState::sliding(Pattern::Edge(0));
            let (mut solver, mut out, mut whole) = (CandidateSolver::new(&p), Solution::new(&p), Solution::new(&p));
            solver.solve(&p, &states, &mut whole);
            let mut condensed = Condensed::new(&p);
            assert!(condensed.condense(&mut solver, &p, &states, &mut out));
            condensed.exchange(&mut p);
            solver.solve(&p, &condensed.loose, &mut out);
            condensed.exchange(&mut p);
            let change = (6..12).map(|i| (out.motion[i] - whole.motion[i]).abs()).fold(0.0, f64::max);
            let size = p.b.iter().map(|b| b.abs()).fold(0.0, f64::max);
            // Rounding, times the ratio of the responses without and with the static sole.
            assert!(change < 1e-9 * size, "{run}: {change:e} of {size:e}");
            count += 1;
        }
        let states = States::default();
        assert!(!Condensed::new(&p).condense(&mut CandidateSolver::new(&p), &p, &states, &mut Solution::new(&p)));
    }
    assert!(count > 10, "{count}");
}

/// A step of a sliding mode of centauro on its wheels, pushed. Where the points do not converge once all that slip
/// have kinetic friction, a fresh start with static friction leads there again: more than one would never end.
#[test]
fn attempts_with_points_end_where_kinetic_friction_has_no_solution() {
    let text = include_str!("wheels_problem.json");
    let record: SelectionRecord = serde_json::from_str(text).expect("a problem");
    let (p, mut out) = (record.problem().expect("it was written as one"), record.last().expect("its last solution"));
    let method = MethodDescriptor::named(&record.method).expect("its method exists");
    let mut solver = (method.solver)(&record.parameters, &p);
    assert_eq!(solver.point_impulse(&p, &mut out), None);
}
