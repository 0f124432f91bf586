//! Falls of `scenarios/studies/falls.toml`, each of which once lost energy or sank in, or did not end.

use super::support::root;
use stiction::Scenario;

/// Seed, samples and run of the study, duration in s, and what the fall meets.
const FALLS: [(i64, i64, usize, f64, &str); 10] = [
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

/// The corners where robots touch the ground are right: nothing sinks in, and energy is lost only where it is
/// accounted for.
#[test]
fn falls_keep_the_energy_balance_and_do_not_sink_in() {
    for (seed, samples, index, duration, what) in FALLS {
        let study = Scenario::load(root().join("scenarios/studies/falls.toml")).unwrap();
        let study = study.set("seed", seed).set("sweep.random.samples", samples).set("duration", duration);
        let mut sim = study.runs().unwrap().remove(index).simulation().unwrap();
        sim.run_to_end(&mut ()).unwrap_or_else(|e| panic!("{what}: {e}"));
        let m = sim.metrics();
        assert!(m.inconsistent == 0 && m.impacts > 5, "{what}: {m:?}");
        // Changes of corners are found up to 1e-9 m.
        assert!(m.max_penetration_m < 1e-8, "{what}: {} m", m.max_penetration_m);
        // Energies are not under error control: at most 1e-5 J here, of 10 to 1000 J.
        assert!(m.max_energy_error_j < 2e-5, "{what}: {} J", m.max_energy_error_j);
    }
}
