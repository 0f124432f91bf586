//! Falls of `scenarios/studies/falls.toml`, each of which once lost energy, sank in, did not end or left the laws.

use super::support::root;
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

/// The same of falls that once showed loads beyond the laws for an instant.
const LOADS: [Fall; 6] = [
    (6, 56, 121, 1.3, "slow slip of one vertex, which cannot be stopped"),
    (6, 56, 137, 1.1, "two thighs and shanks at rest: a singular matrix with positive pivots"),
    (6, 56, 96, 1.3, "slow normal motion of a sliding vertex, which cannot be stopped"),
    (5, 56, 75, 1.6, "the same with a tension of 330 N"),
    (4, 56, 83, 1.8, "one vertex of a sliding edge is slow"),
    (5, 56, 82, 0.8, "a step without a valid state begins with a landing"),
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
    for case in FALLS {
        let (m, what) = (run_to_end(case), case.4);
        // Changes of corners are found up to 1e-9 m.
        assert!(m.max_penetration_m < 1e-8, "{what}: {} m", m.max_penetration_m);
        // Energies are not under error control: at most 1e-5 J here, of 10 to 1000 J.
        assert!(m.max_energy_error_j < 2e-5, "{what}: {} J", m.max_energy_error_j);
    }
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
