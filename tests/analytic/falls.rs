//! Falls of `scenarios/studies/falls.toml`, each of which once lost energy, sank in, did not end or left the laws.

use crate::support::runs::root;
use std::fs;
use stiction::Scenario;
use stiction::sim::{Metrics, Simulation};

/// Seed, samples and run of the study, duration in s, and what the fall meets.
type Fall = (i64, i64, usize, f64, &'static str);

const FALLS: [Fall; 10] = [
    (2, 12, 20, 1.3, "the end of a tilted capsule slides over a border"),
    (2, 12, 15, 0.6, "an edge slides over two edges of a height field in one plane with it"),
    (2, 12, 24, 2.0, "after a jam, slow slip stops when patches follow the states"),
    (4, 56, 89, 0.8, "a peak between two faces of the head, static on both, while the head turns"),
    (4, 56, 42, 1.0, "a vertex on a border slides inwards"),
    (4, 56, 156, 1.0, "the lower end of an edge slides over a border"),
    (4, 56, 78, 1.3, "a ridge comes to lie in a face of a hand: an impact acts along the normal of that face"),
    (5, 56, 83, 1.0, "an edge of the ramp comes to lie in a face of the torso"),
    (6, 56, 63, 2.0, "a corner of the stairs on the border of a face slides inwards"),
    (6, 56, 164, 4.0, "more than 5000 events in a second"),
];

/// The same of falls in which a program without a choice for motion that is left, or without an estimate of least
/// eigenvalues, shows loads beyond the laws: by 2.2, 57, 0.18, 0.78, 8.5 and 65 N.
const LOADS: [Fall; 6] = [
    (4, 56, 61, 0.85, "slow motion of an upper arm, which cannot be stopped"),
    (4, 56, 83, 1.7, "one vertex of a sliding edge is slow"),
    (5, 56, 86, 1.4, "slow motion in a fall with sliding modes"),
    (6, 56, 76, 2.15, "slow slip late in a fall"),
    (5, 56, 143, 2.45, "links at rest: a singular matrix with positive pivots"),
    (6, 56, 134, 1.7, "another one"),
];

/// Falls in which round shapes of links meet borders and edges: without the functions of validity and the turns of
/// rings that they need these sink in by up to 25 mm or lose up to 3.5 J.
const ROUND: [Fall; 6] = [
    (6, 56, 60, 0.6, "the end of an upper arm comes to lie on an edge, and turns about a crossing of its rim"),
    (5, 56, 56, 4.0, "no point of a ring is put in the place of a crossing"),
    (4, 56, 109, 0.7, "a steep side leaves a border"),
    (4, 56, 89, 1.2, "the end of a thigh turns about a crossing with an edge of a height field"),
    (4, 56, 108, 1.6, "the same for longer"),
    (4, 56, 125, 4.0, "a shank"),
];

/// The start of a fall of the study.
pub fn simulation((seed, samples, index, duration, _): Fall) -> Simulation {
    let study = Scenario::load(root().join("scenarios/studies/falls.toml")).unwrap();
    let study = study.set("seed", seed).set("sweep.random.samples", samples).set("duration", duration);
    study.runs().unwrap().remove(index).simulation().unwrap()
}

fn run_to_end(fall: Fall) -> Metrics {
    let (mut sim, what) = (simulation(fall), fall.4);
    sim.run_to_end(&mut ()).unwrap_or_else(|e| panic!("{what}: {e}"));
    let m = sim.metrics().clone();
    assert!(m.inconsistent == 0 && m.impacts > 5, "{what}: {m:?}");
    m
}

/// The corners where robots touch the ground are right: nothing sinks in, and energy is lost only where it is
/// accounted for.
#[test]
fn falls_keep_the_energy_balance_and_do_not_sink_in() {
    for case in FALLS.into_iter().chain(ROUND) {
        let (m, what) = (run_to_end(case), case.4);
        // Changes of corners are found up to 1e-9 m.
        assert!(m.max_penetration_m < 1e-8, "{what}: {} m", m.max_penetration_m);
        // Energies are not under error control: at most 1e-5 J here, of 10 to 1000 J.
        assert!(m.max_energy_error_j < 2e-5, "{what}: {} J", m.max_energy_error_j);
    }
}

/// An upper arm comes to lie on an edge. The plane of two almost parallel edges turns within a step, whose end then has
/// 2 m/s across it: no drift. Rounding decides whether a step ends there; a program that took it for drift lost 3.7 J in
/// 4 of 24 such runs.
#[test]
fn a_plane_that_turns_within_a_step_stops_no_motion() {
    for k in 0..8 {
        let path = root().join("scenarios/studies/falls.toml");
        let study = Scenario::load(path).unwrap().set("seed", 6).set("sweep.random.samples", 56);
        let study =
            study.set("duration", 0.48).set("integrator.absolute_tolerance", 1e-8 * (1.0 + 1e-6 * f64::from(k)));
        let mut sim = study.runs().unwrap().remove(60).simulation().unwrap();
        sim.run_to_end(&mut ()).unwrap();
        // The integrator: at most 3e-6 J.
        let error = sim.metrics().max_energy_error_j;
        assert!(error < 2e-5, "{k}: {error} J");
    }
}

/// Loads of falls on the floor alone (40 samples): states whose loads are not within the laws at the end of a choice, by
/// 194, 52 and 0.56 N, are left to velocity-level steps; CB-i rattles in sliding modes of 9 ms.
#[test]
fn falls_on_the_floor_keep_their_loads_within_the_laws() {
    let path = root().join("scenarios/studies/falls.toml");
    let text = fs::read_to_string(&path).unwrap();
    let plain: Vec<&str> = text.split("\n\n").filter(|part| !part.contains("[[terrain]]")).collect();
    let plain = plain.join("\n\n");
    let plain: Vec<&str> = plain.lines().filter(|line| !line.starts_with("\"terrain.")).collect();
    for (seed, index, duration) in [(11, 66, 2.29), (11, 58, 1.94), (13, 104, 1.53), (12, 70, 2.0)] {
        let study = Scenario::parse(&path, plain.join("\n")).unwrap();
        let study = study.set("seed", seed).set("sweep.random.samples", 40).set("duration", duration);
        let mut sim = study.runs().unwrap().remove(index).simulation().unwrap();
        sim.run_to_end(&mut ()).unwrap();
        let m = sim.metrics();
        assert!(m.max_cone_excess < 1e-8 && m.max_tension_n < 1e-8 && m.inconsistent == 0, "{index}: {m:?}");
    }
}

/// A sliding mode in which vertices stop in every second step has errors that grow with its steps: their size stays.
#[test]
fn the_size_of_steps_in_a_sliding_mode_grows_only_where_errors_do_not() {
    // Energies of 50 J; 2.3 mJ with steps that grow.
    let m = run_to_end((5, 56, 101, 0.48, "a foot on two edges of a height field"));
    assert!(m.sliding_mode_s > 1e-4 && m.max_energy_error_j < 3e-4, "{m:?}");
}

/// At every instant, also at events, the loads are those of states within the laws.
#[test]
fn falls_keep_their_loads_within_the_laws() {
    for case in LOADS {
        let (m, what) = (run_to_end(case), case.4);
        // Rounding of loads of up to 1e4 N.
        assert!(m.max_cone_excess < 1e-8, "{what}: {} N", m.max_cone_excess);
        assert!(m.max_tension_n < 1e-8, "{what}: {} N", m.max_tension_n);
        // Slow motion that is left.
        assert!(m.max_creep_speed_m_per_s < 1e-5, "{what}: {} m/s", m.max_creep_speed_m_per_s);
    }
}
