//! `sine` against its closed form.

use super::{Folder, PENDULUM, TickCommand, commands, unsteadiness};
use std::f64::consts::{PI, TAU};

fn swing(task: &str) -> Vec<TickCommand> {
    commands(&Folder::with(&[]), &format!("{PENDULUM}[[task]]\ntype = \"sine\"\n{task}\n"))
}

#[test]
fn without_a_ramp_the_motion_is_a_sine_from_the_start() {
    let commanded = swing(
        "start = 0.5\nramp = 0\njoints = { shoulder = { amplitude = 0.2, frequency = 1.5, phase = \"90 deg\" }, elbow = { \
         amplitude = 0.1, offset = 0.4 } }",
    );
    for a in &commanded {
        let t = a.time - 0.5;
        let (expected, rate) = if t < -1e-9 {
            ([0.3, -0.2], [0.0, 0.0])
        } else {
            let theta = TAU * 1.5 * t + PI / 2.0;
            let slow = TAU * t;
            ([0.3 + 0.2 * theta.sin(), 0.4 + 0.1 * slow.sin()], [0.2 * TAU * 1.5 * theta.cos(), 0.1 * TAU * slow.cos()])
        };
        for j in 0..2 {
            // Roundings of phases of some 40 rad, and of velocities of some 2 rad/s.
            assert!((a.position[j] - expected[j]).abs() < 1e-14 && (a.velocity[j] - rate[j]).abs() < 1e-13, "{a:?}");
        }
    }
}

#[test]
fn ramps_begin_and_end_at_rest() {
    let commanded =
        swing("duration = 3.0\nramp = 0.8\njoints = { shoulder = { amplitude = 0.2, phase = 1.0, offset = -0.1 } }");
    let at = |t: f64| commanded[(t * 1000.0).round() as usize].clone();
    assert_eq!((at(0.0).position[0], at(0.0).velocity[0]), (0.3, 0.0));
    // Half way up the ramp r = 1/2 and r' = 15/8 / 0.8.
    let away = -0.1 + 0.2 * (TAU * 0.4 + 1.0).sin() - 0.3;
    let turning = 0.2 * TAU * (TAU * 0.4 + 1.0).cos();
    let half = at(0.4);
    assert!((half.position[0] - (0.3 + 0.5 * away)).abs() < 1e-14);
    assert!((half.velocity[0] - (1.875 / 0.8 * away + 0.5 * turning)).abs() < 1e-13);
    // And down again; then it is at rest.
    let away = -0.1 + 0.2 * (TAU * 2.6 + 1.0).sin() - 0.3;
    assert!((at(2.6).position[0] - (0.3 + 0.5 * away)).abs() < 1e-14);
    for t in [3.0, 3.5, 4.0] {
        assert!((at(t).position[0] - 0.3).abs() < 1e-15 && at(t).velocity[0] == 0.0, "{:?}", at(t));
    }
    assert!(commanded.iter().all(|a| (a.position[1], a.velocity[1]) == (-0.2, 0.0)));
    let (apart, step) = unsteadiness(&commanded, 0, &[]);
    // Central differences over 1 ms miss h^2 / 6 times the third derivative, some 60 * 0.6 / 0.8^3
    // + 0.2 * TAU^3. A velocity moves by no more than the greatest acceleration (some 15) times 1
    // ms.
    assert!(apart < 3e-5 && step < 0.02, "{apart} {step}");
}

#[test]
fn the_phase_is_continuous_across_changes() {
    let commanded = swing(
        "ramp = 0\njoints = { shoulder = { amplitude = 0.2, frequency = 1.3 } }\nchange = [{ at = 1.0, joints = { shoulder = { \
         frequency = 0.4 } } }, { at = 2.5, joints = { shoulder = { amplitude = 0.1, offset = 0.5 } } }]",
    );
    for a in &commanded {
        let t = a.time;
        let theta = TAU * if t < 1.0 - 1e-9 { 1.3 * t } else { 1.3 + 0.4 * (t - 1.0) };
        let expected = if t < 2.5 - 1e-9 { 0.3 + 0.2 * theta.sin() } else { 0.5 + 0.1 * theta.sin() };
        assert!((a.position[0] - expected).abs() < 1e-14, "{a:?}");
    }
}

#[test]
fn with_a_ramp_nothing_jumps_at_a_change() {
    let commanded = swing(
        "ramp = 0.5\njoints = { shoulder = { amplitude = 0.2, frequency = 1.3 } }\nchange = [{ at = 1.0, joints = { shoulder = { \
         frequency = 3.0, amplitude = 0.3 } } }, { at = 2.5, joints = { shoulder = { amplitude = 0.05, offset = 0.1 } } }]",
    );
    let (apart, step) = unsteadiness(&commanded, 0, &[]);
    // Third derivatives of up to 0.3 * (TAU 3)^3 = 2000, accelerations of up to 0.3 * (TAU 3)^2 =
    // 110.
    assert!(apart < 5e-4 && step < 0.15, "{apart} {step}");
    // The frequency's mean over its glide is (1.3 + 3) / 2: phase at 1.5 s, then 3 Hz.
    let theta = TAU * (1.3 + 0.5 * 0.5 * (1.3 + 3.0) + 3.0 * 0.7);
    let a = &commanded[2200];
    assert!((a.position[0] - (0.3 + 0.3 * theta.sin())).abs() < 1e-14, "{a:?}");
}

#[test]
fn later_tasks_win_on_a_simulated_robot() {
    let folder = Folder::with(&[]);
    let commanded = commands(
        &folder,
        &format!(
            "{PENDULUM}[[task]]\ntype = \"sine\"\njoints = {{ shoulder = {{ amplitude = 0.2 }} }}\n[[task]]\ntype = \
             \"posture\"\nstart = 1.0\nduration = 0.5\njoints = {{ shoulder = 0.0 }}\n"
        ),
    );
    assert_eq!(commanded[1500].position[0], 0.0);
    assert!(commanded[1600].position[0].abs() > 1e-3, "the sine has it again");
    // A stiff servo follows the sine; the command is constant for 1 ms at 0.63 rad/s.
    let (metrics, recording, _) = folder.watch(&format!(
        "{}[[task]]\ntype = \"sine\"\njoints = {{ shoulder = {{ amplitude = 0.2, frequency = 0.5, offset = 0 }} }}\n",
        PENDULUM.replace("posture", "joint_default = { mode = \"position\", kp = 1e5, kd = 1e3 }, soles = [], posture")
    ));
    assert_eq!(metrics.state_changes, 0);
    let last = recording.snapshots.last().unwrap();
    // 0.2 sin(TAU 0.5 4) = 0, commanded a tick late.
    assert!(last.q[0].abs() < 0.63e-3, "{}", last.q[0]);
}
