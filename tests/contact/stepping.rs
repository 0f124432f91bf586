//! Time-stepping methods on random impacts: their complementarity conditions, checked from forces
//! and motions alone.

use super::impact::falling;
use super::pair::{JOINTS, pair};
use super::rigid::{Rigid, body_on, rules, triple};
use nalgebra::{Matrix3, Vector2, Vector3};
use proptest::prelude::*;
use stiction::contact::methods::contact_method::SelectionInput;
use stiction::contact::methods::lcp::LcpParameters;
use stiction::contact::methods::ncp::NcpParameters;
use stiction::contact::methods::registry::{MethodDescriptor, MethodParameters};
use stiction::contact::model::problem::Problem;
use stiction::contact::model::solution::Solution;
use stiction::contact::search::select::Selection;

/// Answer of a method without a previous solution.
fn solve_first(name: &str, parameters: &MethodParameters, p: &mut Problem) -> (Selection, Solution) {
    let (mut method, mut out) =
        ((MethodDescriptor::named(name).expect("registered").solver)(parameters, p), Solution::new(p));
    let rules = rules();
    let input = SelectionInput { rules: &rules, event: false, allowed: &|_, _| true, cancel: None };
    let selection = method.impulse(p, &input, &mut out);
    (selection, out)
}

/// Greatest violation of the conditions of `lcp` with m directions, or of the round cone without: m
/// = b + W w with the wrenches of the vertex forces; Signorini; friction inside its cone with
/// maximal dissipation. Relative to the greatest velocity and impulse.
fn violation(p: &Problem, out: &Solution, facets: Option<u32>) -> f64 {
    let speed = p.b.iter().map(|b| b.abs()).fold(0.0, f64::max);
    let load = out.normal.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut miss: f64 = 0.0;
    let n = p.dim();
    let mut wrench = vec![0.0; n];
    for (s, sole) in p.soles.iter().enumerate() {
        for (i, v) in sole.vertices.iter().enumerate() {
            let f = out.tangent[s][i].push(out.normal[s][i]);
            let m = v.r.cross(&f);
            [f.x, f.y, f.z, m.x, m.y, m.z].iter().enumerate().for_each(|(c, x)| wrench[6 * s + c] += x);
        }
    }
    for r in 0..n {
        let m: f64 = p.b[r] + (0..n).map(|c| p.w[n * r + c] * wrench[c]).sum::<f64>();
        miss = miss.max((m - out.motion[r]).abs() / speed);
    }
    for (s, sole) in p.soles.iter().enumerate() {
        for (i, v) in sole.vertices.iter().enumerate() {
            let (normal, t) = (out.normal[s][i], out.tangent[s][i]);
            let motion = p.vertex_motion(&out.motion, s, i);
            let (gap, slip) = (motion.z - sole.vertex_target(i), motion.xy());
            // Support of the cone's section in a direction: the greatest friction against it.
            let support = |d: &Vector2<f64>| match facets {
                Some(m) => directions(m).map(|e| e.dot(d)).fold(0.0, f64::max),
                None => d.norm(),
            };
            miss = miss.max(-normal / load).max(-gap / speed).max((normal * gap).abs() / (load * speed));
            // Inside the cone: in the direction of each facet at most its distance from the axis.
            let outside = match facets {
                Some(m) => {
                    let half = std::f64::consts::PI / f64::from(m);
                    let facets = directions(m).map(|e| nalgebra::Rotation2::new(half) * e);
                    facets.map(|n| n.dot(&t) - v.mu_k * normal * half.cos()).fold(0.0, f64::max)
                }
                None => t.norm() - v.mu_k * normal,
            };
            let dissipation_defect = v.mu_k * normal * support(&-slip) + t.dot(&slip);
            miss = miss.max(outside / load).max(dissipation_defect.abs() / (load * speed));
        }
    }
    miss
}

fn directions(m: u32) -> impl Iterator<Item = Vector2<f64>> {
    (0..m).map(move |j| {
        let (s, c) = (f64::from(j) * std::f64::consts::TAU / f64::from(m)).sin_cos();
        Vector2::new(c, s)
    })
}

fn with_facets(facets: u32) -> MethodParameters {
    MethodParameters { lcp: LcpParameters { facets }, ..MethodParameters::default() }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(23),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn lcp_solves_its_problem(body in body_on(1, 8), velocity in triple(), spin in triple(), half in 2u32..9) {
        let mut p = falling(&body, &velocity, &spin);
        let before = p.b.clone();
        let (selection, out) = solve_first("lcp", &with_facets(2 * half), &mut p);
        prop_assert!(selection.consistent);
        // Rounding of some tens of pivots.
        prop_assert!(violation(&p, &out, Some(2 * half)) < 1e-10, "{:.3e}", violation(&p, &out, Some(2 * half)));
        prop_assert!(body.energy(&out.motion) <= body.energy(&before) * (1.0 + 1e-10));
    }

    #[test]
    fn lcp_solves_its_problem_on_two_bodies_with_any_joint(
        pair in pair(JOINTS), fall in [triple(), triple()], spin in [triple(), triple()], half in 2u32..6
    ) {
        let fall = fall.map(|v| Vector3::new(2.0 * v.x, 2.0 * v.y, v.z - 1.2));
        let mut p = pair.falling(&fall, &spin.map(|s| s * 6.0));
        let (selection, out) = solve_first("lcp", &with_facets(2 * half), &mut p);
        prop_assert!(selection.consistent);
        prop_assert!(violation(&p, &out, Some(2 * half)) < 1e-10, "{:.3e}", violation(&p, &out, Some(2 * half)));
    }

    #[test]
    fn ncp_converges_to_the_round_cone(body in body_on(1, 8), velocity in triple(), spin in triple()) {
        let mut p = falling(&body, &velocity, &spin);
        let ncp = NcpParameters { iterations: 100_000, tolerance: 1e-12 };
        let (_, out) = solve_first("ncp", &MethodParameters { ncp, ..MethodParameters::default() }, &mut p);
        prop_assert!(violation(&p, &out, None) < 1e-8, "{:.3e}", violation(&p, &out, None));
    }
}

#[test]
fn ncp_converges_at_a_geometric_rate() {
    // A box of friction 0.5 lands on its sole and slides: four points, unequally loaded.
    let body = Rigid {
        sole: [(0.1, 0.06), (-0.1, 0.06), (-0.1, -0.06), (0.1, -0.06)].map(|(x, y)| Vector2::new(x, y)).to_vec(),
        mass: 2.0,
        inertia: Matrix3::from_diagonal(&Vector3::new(0.004, 0.009, 0.011)),
        com: Vector3::new(0.02, -0.01, 0.05),
        mu: [0.5, 0.5],
    };
    let p = falling(&body, &Vector3::new(0.3, 0.1, -0.2), &Vector3::new(0.02, 0.03, 0.1));
    let miss = |iterations: u32| {
        let ncp = NcpParameters { iterations, tolerance: 1e-15 };
        let mut p = p.clone();
        let (_, out) = solve_first("ncp", &MethodParameters { ncp, ..MethodParameters::default() }, &mut p);
        violation(&p, &out, None)
    };
    let misses = [4, 8, 12, 16, 20, 24, 28, 32].map(miss);
    let rates: Vec<f64> = misses.windows(2).map(|w| w[1] / w[0]).collect();
    println!("{misses:?} {rates:?}");
    // A factor of about ten every four sweeps over eight powers of ten; then rounding.
    assert!(rates.iter().all(|r| (0.04..0.16).contains(r)), "{rates:?}");
    assert!(misses[0] > 1e-3 && misses[7] < 1e-9 && miss(400) < 1e-14, "{misses:?}");
}
