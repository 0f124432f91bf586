//! `balance` with `control = "position"` in short simulations.

use crate::support::runs::{simulation, watch};
use std::sync::atomic::AtomicBool;
use stiction::dynamics::body;
use stiction::sim::NullObserver;

/// World position of HOAP-2's centre of mass at the end, m.
fn end(task: &str) -> nalgebra::Vector3<f64> {
    let text = format!(
        "duration = 3\nrobot = {{ model = \"robots/hoap2/hoap2.toml\" }}\n[integrator]\nmethod = \"semi-implicit\"\n\
         [log]\nrate = 0\n{task}"
    );
    let mut sim = simulation(&text);
    let (_, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    assert_eq!(sim.metrics().state_changes, 0, "{message}");
    body::center_of_mass(&sim.plant().ws)
}

#[test]
fn the_centre_of_mass_moves_over_the_point_of_optimal_stability() {
    // Soles start with their ankles at x = -0.034, so the middle of their common rectangle is at
    // -0.034 + 0.0112 (README of hoap2).
    let middle = -0.0228;
    let without = end("");
    assert!((without.x - middle).abs() > 3e-3, "{without}");
    let task = "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { leaning = 3, approach = 0.3 }\n";
    let com = end(task);
    // The rest decays with 3 1/s for 2.7 s: 4 mm exp(-8.1) = 1.2 um, and some sway.
    assert!((com.x - middle).abs() < 1e-5 && com.y.abs() < 1e-5, "{com}");
    // An offset moves it, with any sag of the servos: here without feed-forward efforts.
    let task = task.replace("leaning = 3", "leaning = 0, integral = 4, feed_forward = false, offset = [0.01, -0.02]");
    let com = end(&task);
    assert!((com.x - middle - 0.01).abs() < 1e-4 && (com.y + 0.02).abs() < 1e-4, "{com}");
    // A later offset moves it too, from the position after the first. 1.2 s at 4 1/s leave 1 % of
    // the 10 mm, apart from the initial error of the commanded posture.
    let task = format!(
        "{task}change = [{{ at = 1.5, position = {{ offset = [0.005, -0.01], approach = 0.3 }} }}, {{ at = 1.6, position = {{ integral = 6 }} }}]\n"
    );
    let com = end(&task);
    assert!((com.x - middle - 0.005).abs() < 1e-4 && (com.y + 0.01).abs() < 1e-4, "{com}");
}

#[test]
fn planned_points_are_shown() {
    let points = |robot: &str, task: &str| {
        let text = format!(
            "duration = 3\nrobot = {{ model = \"{robot}\" }}\n[integrator]\nmethod = \"semi-implicit\"\n[log]\nrate = 10\n{task}"
        );
        let (_, recorded) = watch(&text);
        let last = recorded.snapshots.last().unwrap();
        let names: Vec<_> = last.points.iter().map(|p| p.name.clone()).collect();
        let at: Vec<_> = last.points.iter().map(|p| p.position).collect();
        (names, at, last.com, last.centre_of_pressure.unwrap())
    };
    let hoap2 = "robots/hoap2/hoap2.toml";
    for task in [
        "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { leaning = 3, approach = 0.3 }\n",
        "[[task]]\ntype = \"balance\"\ncontrol = \"force\"\nforce = { approach = 0.3 }\n",
    ] {
        let (names, at, com, cop) = points(hoap2, task);
        assert_eq!(names, ["balance.com", "balance.zmp"]);
        let (expected, zmp) = (at[0].unwrap(), at[1].unwrap());
        // At rest over the soles; after 3 s the error is some tenths of a millimetre.
        assert!((expected - com).norm() < 2e-3, "{task}: {expected} {com}");
        assert!((zmp - cop).norm() < 2e-3, "{task}: {zmp} {cop}");
    }
    // Two tasks of a type have distinct points; gravity compensation has no desired position.
    let twice = "[[task]]\ntype = \"gravity-compensation\"\nduration = 1\n[[task]]\ntype = \"gravity-compensation\"\nstart = 1\n";
    let (names, at, _, cop) = points(hoap2, twice);
    let name = |rest: &str| format!("gravity-compensation.{rest}");
    assert_eq!(names, ["com", "zmp", "com.2", "zmp.2"].map(name));
    assert_eq!((at[0], at[1], at[2]), (None, None, None));
    assert!((at[3].unwrap() - cop).norm() < 5e-3, "{:?} {cop}", at[3]);
}

/// A robot of human size with default gains comes to rest instead of rocking.
#[test]
fn a_tall_robot_comes_to_rest() {
    let text = "duration = 6\nrobot = { model = \"robots/cbi/cbi.toml\" }\n[integrator]\nmethod = \"semi-implicit\"\n[log]\nrate = 0\n\
                [[task]]\ntype = \"balance\"\ncontrol = \"position\"\n";
    let mut sim = simulation(text);
    let (_, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    let speed = sim.metrics().final_base_velocity.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    // The error after some seconds decays with leaning, 1.2 1/s.
    assert!(speed < 2e-3 && sim.metrics().state_changes < 50, "{speed} {} {message}", sim.metrics().state_changes);
}
