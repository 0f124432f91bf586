//! `squat` and `walk` in short simulations.

use crate::support::runs::{simulation, watch};
use nalgebra::Vector3;
use std::sync::atomic::AtomicBool;
use stiction::dynamics::body;
use stiction::sim::{NullObserver, Outcome, Snapshot};

const HOAP2: &str = "robot = { model = \"robots/hoap2/hoap2.toml\" }\n";
/// Height of the centre of mass of the home posture above the soles, m.
const HOME: f64 = 0.260362;

#[test]
fn a_squat_reaches_its_depth_with_fixed_feet() {
    // Ends at the bottom: 0.2 s to settle, half of 0.8 s down.
    let text = format!(
        "duration = 0.6\n{HOAP2}[log]\nrate = 0\n[[task]]\ntype = \"squat\"\ndepth = 0.02\nperiod = 0.8\nsettle = 0.2\n"
    );
    let mut sim = simulation(&text);
    let (_, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    let metrics = sim.metrics();
    assert_eq!((metrics.state_changes, metrics.inconsistent), (0, 0), "{message}");
    let com = body::center_of_mass(&sim.plant().ws);
    // Servos with gravity feed-forward follow a motion of 0.8 s to a part of its 20 mm.
    assert!((com.z - (HOME - 0.02)).abs() < 5e-4, "{com}");
}

#[test]
fn a_step_lifts_and_lands_one_foot_after_the_other() {
    let text = format!(
        "duration = 3.4\n{HOAP2}[log]\nrate = 50\n[stop]\nfallen = {{ below = 0.2 }}\n[[task]]\ntype = \"walk\"\n\
         steps = 1\nstep_time = 0.8\nwait = 0.8\nsettle = 0.3\nfirst = \"right\"\n"
    );
    let (metrics, recorded) = watch(&text);
    // 0.3 s at rest, 0.8 s of swaying, 0.2 s on both feet, then the right foot rises; it lands
    // again at 1.9 s.
    let up = metrics.first_liftoff_s.expect("it lifts a foot");
    assert!(up > 1.1 && up < 1.6, "{up}");
    let lifted: Vec<bool> =
        (0..2).map(|s| recorded.snapshots.iter().any(|t| t.soles[s].positions.iter().all(|p| p.z > 5e-3))).collect();
    assert_eq!(lifted, [false, true]);
    // The task shows its targets while it runs, 2.9 s.
    let shown = |s: &Snapshot, name: &str| s.points.iter().find(|p| p.name == name).expect(name).position;
    for s in &recorded.snapshots {
        let points = ["walk.com", "walk.zmp", "walk.foot.left", "walk.foot.right"].map(|name| shown(s, name));
        assert!(points.iter().all(|p| p.is_some() == (s.time < 2.9 - 1e-9)), "{}", s.time);
        let [Some(com), Some(zmp), Some(left), Some(right)] = points else { continue };
        // Servos with gravity feed-forward follow within millimetres. The reference of the
        // zero-moment point jumps from foot to foot in 0.2 s, which no centre of mass follows
        // exactly.
        assert!((com - s.com).norm() < 5e-3, "{} {com} {}", s.time, s.com);
        assert!((zmp - s.centre_of_pressure.expect("it stands")).norm() < 0.05, "{}", s.time);
        for (sole, name, foot) in [(0, "left", left), (1, "right", right)] {
            let corners = &s.soles[sole].positions;
            let middle = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
            let is_down = corners.iter().all(|p| p.z < 1e-4);
            // The last step lands level with the other foot: it has no length.
            assert!(!is_down || (middle - foot).norm() < 5e-3, "{name} at {}: {middle} {foot}", s.time);
        }
    }
    let last = recorded.snapshots.last().unwrap();
    assert!(last.soles.iter().all(|s| s.positions.iter().all(|p| p.z < 1e-4)));
}

#[test]
fn a_walk_requires_vertical_gravity() {
    for gravity in ["[0, -1.5, -9.69]", "[0, 0, 9.81]"] {
        let text = format!(
            "duration = 0.1\ngravity = {gravity}\nrobot = {{ model = \"robots/hoap2/hoap2.toml\" }}\n[[task]]\ntype = \"walk\"\n"
        );
        let (outcome, message) = simulation(&text).run(&mut NullObserver, &AtomicBool::new(false));
        assert_eq!(outcome, Outcome::Error);
        assert!(message.contains("requires vertical gravity"), "{message}");
    }
}
