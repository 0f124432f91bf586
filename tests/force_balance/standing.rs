//! Robots that stand, and are pushed, under force control.

use crate::support::runs::{run, watch};
use nalgebra::Vector3;

/// HOAP-2 on its soles.
pub const HOAP: &str = "duration = 3.0\nrobot = { model = \"robots/hoap2/hoap2.toml\" }\n";
/// Position of its root at home, m.
const HEIGHT: f64 = 0.28343852;

const BALANCE: &str = "[[task]]\ntype = \"balance\"\ncontrol = \"force\"\n";
const COMPENSATION: &str = "[[task]]\ntype = \"gravity-compensation\"\n";

fn push(impulse: f64) -> String {
    // A half-sine of 0.1 s.
    let peak = impulse * std::f64::consts::PI / 0.2;
    format!(
        "[[force]]\ntype = \"push\"\nlink = \"torso\"\npoint = [0, 0, 0.05]\nforce = [{peak}, 0, 0]\nstart = 0.2\n\
         duration = 0.1\nprofile = \"half-sine\"\n"
    )
}

#[test]
fn gravity_compensation_keeps_a_resting_robot_at_rest() {
    let m = run(&format!("{HOAP}{COMPENSATION}"));
    let [x, y, z] = m.final_base_position;
    // An exact equilibrium: only rounding moves it.
    assert!(x.abs() < 1e-11 && y.abs() < 1e-11 && (z - HEIGHT).abs() < 1e-8, "{x:e} {y:e} {z}");
    assert!(m.final_base_velocity.iter().all(|v| v.abs() < 1e-11), "{:?}", m.final_base_velocity);
    assert_eq!((m.state_changes, m.inconsistent), (0, 0));
}

#[test]
fn gravity_compensation_yields_without_returning() {
    let m = run(&format!("{HOAP}{COMPENSATION}{}", push(0.1)));
    let x = m.final_base_position[0];
    assert!((1e-3..0.05).contains(&x), "{x}");
}

#[test]
fn the_centre_of_mass_moves_above_the_middle_of_the_soles() {
    let (m, recorded) = watch(&format!("{}{BALANCE}force = {{ approach = 0.5 }}\n", HOAP.replace("3.0", "8.0")));
    let end = recorded.snapshots.last().expect("the last state is always reported");
    let vertices: Vec<Vector3<f64>> = end.soles.iter().flat_map(|s| &s.positions).copied().collect();
    let middle = vertices.iter().sum::<Vector3<f64>>() / vertices.len() as f64;
    // The slowest mode, the null-space motion, decays within a second or two; the reference is
    // reached exactly.
    assert!((end.com - middle).xy().norm() < 1e-6, "{} {middle}", end.com);
    let pressure = end.centre_of_pressure.expect("it stands");
    assert!((pressure - middle).norm() < 1e-5, "{pressure} {middle}");
    // Ticks change the efforts a thousand times a second; no contact changes.
    assert_eq!((m.state_changes, m.events, m.inconsistent), (0, 0, 0));
    assert!(m.max_static_creep_m < 1e-12, "{:e}", m.max_static_creep_m);
}

#[test]
fn a_pushed_robot_recovers_only_with_balance() {
    // Well below the limit found by scenarios/studies/push-recovery.toml.
    let text = |task: &str| format!("{HOAP}{task}{}[stop]\nsunk_link = \"ignore\"\n", push(1.0));
    let back = |task: &str| run(&text(task)).final_base_position;
    let quiet = run(&format!("{HOAP}{BALANCE}")).final_base_position;
    let balanced = back(BALANCE);
    assert!((0..3).all(|i| (balanced[i] - quiet[i]).abs() < 1e-3), "{balanced:?} {quiet:?}");
    let lost = back(COMPENSATION);
    assert!((lost[0] - quiet[0]).abs() > 0.02, "{lost:?}");
}

#[test]
fn a_robot_stands_with_fixed_steps_too() {
    let m = run(&format!("{HOAP}{BALANCE}[integrator]\nmethod = \"semi-implicit\"\n"));
    let quiet = run(&format!("{HOAP}{BALANCE}")).final_base_position;
    // A step of 1 ms departs from the path to the reference at first order; both end there.
    assert!((0..3).all(|i| (m.final_base_position[i] - quiet[i]).abs() < 1e-5), "{m:?} {quiet:?}");
    assert_eq!((m.state_changes, m.inconsistent), (0, 0));
}

#[test]
fn joints_follow_other_tasks_during_balance() {
    let wave = "[[task]]\ntype = \"posture\"\nduration = 1.0\njoints = { left_elbow = -1.0, head_pan = 0.5 }\n";
    let (_, recorded) = watch(&format!("{HOAP}{wave}{BALANCE}"));
    let end = recorded.snapshots.last().expect("the last state is always reported");
    let model = crate::support::runs::simulation(HOAP).plant().model.clone();
    let position = |name: &str| end.q[model.joint(name).expect("it has one").0];
    // The centre of mass is not where it was at home, so not all joints can reach their commands.
    // The legs deviate by its 4 mm over their 0.2 m, 0.02 rad, and the others by less.
    assert!((position("left_elbow") + 1.0).abs() < 0.02, "{}", position("left_elbow"));
    assert!((position("head_pan") - 0.5).abs() < 0.02, "{}", position("head_pan"));
}

#[test]
fn balance_ends_on_time_and_restores_the_drives() {
    let (m, recorded) = watch(&format!("{HOAP}{BALANCE}duration = 0.5\n"));
    let end = recorded.events.iter().find(|e| e.message == "task balance ends").expect("it ends");
    assert!((end.time - 0.5).abs() < 1e-12, "{}", end.time);
    // The position servos hold the robot at its position, apart from their sag.
    assert!((m.final_base_position[2] - HEIGHT).abs() < 1e-3, "{m:?}");
}

/// Half the rate that the default gains are tuned for, and a fifth of it.
#[test]
fn balance_stands_at_lower_control_rates() {
    for rate in [500, 200] {
        let m = run(&format!(
            "duration = 5.0\nrobot = {{ model = \"robots/cbi/cbi.toml\" }}\n[control]\nrate = {rate}\n[integrator]\n\
             method = \"semi-implicit\"\nstep = 1e-3\n{BALANCE}"
        ));
        let speed = m.final_base_velocity.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        // Its pelvis is at 0.80 m and at rest.
        assert!((m.final_base_position[2] - 0.802).abs() < 5e-3 && speed < 1e-3, "{rate}: {m:?}");
    }
}
