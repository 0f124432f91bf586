//! `playback` of posture files and tables.

use super::{Folder, PENDULUM, TickCommand, commands, unsteadiness};

const POSTURES: &str = "description = \"to and fro\"
[[posture]]
at = 0
joints = { shoulder = 0.3, elbow = \"0 deg\" }
[[posture]]
at = 1
joints = { shoulder = 0.8 }
[[posture]]
at = 2
joints = { shoulder = -0.2, elbow = 1.0 }
";

fn play(task: &str) -> Vec<TickCommand> {
    let folder = Folder::with(&[("m.toml", POSTURES)]);
    commands(&folder, &format!("{PENDULUM}[[task]]\ntype = \"playback\"\nfile = \"m.toml\"\n{task}\n"))
}

fn at(commanded: &[TickCommand], t: f64) -> &TickCommand {
    &commanded[(t * 1000.0).round() as usize]
}

/// The minimum-jerk quintic of two knots.
fn minimum_jerk(s: f64) -> f64 {
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

#[test]
fn postures_are_met_at_their_times() {
    let commanded = play("start = 0.5\nblend = 0");
    for (t, shoulder) in [(0.25, 0.3), (0.5, 0.3), (1.5, 0.8), (2.5, -0.2), (4.0, -0.2)] {
        assert!((at(&commanded, t).position[0] - shoulder).abs() < 1e-14, "{t}: {:?}", at(&commanded, t));
    }
    // The elbow has two postures: one minimum-jerk move, which begins with a jump from -0.2 because
    // there is no blend.
    assert_eq!(at(&commanded, 0.499).position[1], -0.2);
    for k in 0..=20 {
        let s = f64::from(k) / 20.0;
        assert!((at(&commanded, 0.5 + 2.0 * s).position[1] - minimum_jerk(s)).abs() < 1e-14);
    }
    assert_eq!(at(&commanded, 3.0).velocity, [0.0, 0.0]);
    let (apart, step) = unsteadiness(&commanded, 0, &[]);
    // Jerks of up to some 60 at the ends, accelerations of up to 10.
    assert!(apart < 2e-5 && step < 0.02, "{apart} {step}");
}

#[test]
fn the_previous_command_decays() {
    let commanded = play("blend = 0.4");
    // The shoulder begins at its command, at rest: no offset. The elbow is off by 0.2.
    let plain = play("blend = 0");
    for (a, b) in commanded.iter().zip(&plain) {
        assert_eq!(a.position[0], b.position[0]);
        let left = if a.time < 0.4 { -0.2 * (1.0 - minimum_jerk(a.time / 0.4)) } else { 0.0 };
        // Roundings of the quintic's three sums.
        assert!((a.position[1] - b.position[1] - left).abs() < 1e-15, "{}", a.time);
    }
    let (apart, step) = unsteadiness(&commanded, 1, &[]);
    assert!(apart < 5e-4 && step < 0.02, "{apart} {step}");
}

#[test]
fn speed_stretches_time_and_changes_without_a_jump() {
    let (once, twice) = (play("blend = 0"), play("blend = 0\nspeed = 2"));
    for (a, b) in once.iter().step_by(2).zip(&twice).take(1001) {
        assert!((a.position[0] - b.position[0]).abs() < 1e-14 && (2.0 * a.velocity[0] - b.velocity[0]).abs() < 1e-13);
    }
    let commanded = play("blend = 0.2\nspeed = 0.5\nchange = [{ at = 1.0, speed = 0 }, { at = 3.0, speed = 2 }]");
    // 0.5 s of the motion in the first second, 0.5 * 0.2 / 2 more while it stops; then it is at
    // rest.
    let stood = play("blend = 0")[550].position[0];
    for t in [1.2, 2.0, 3.0] {
        let a = at(&commanded, t);
        assert!((a.position[0] - stood).abs() < 1e-14 && a.velocity[0].abs() < 1e-14, "{a:?}");
    }
    // 2 * 0.2 / 2 and then 2 a second.
    let moved = &play("blend = 0")[550 + 200 + 1000];
    let a = at(&commanded, 3.7);
    assert!(
        (a.position[0] - moved.position[0]).abs() < 1e-13 && (a.velocity[0] - 2.0 * moved.velocity[0]).abs() < 1e-12
    );
    let (apart, step) = unsteadiness(&commanded, 0, &[]);
    assert!(apart < 5e-4 && step < 0.05, "{apart} {step}");
}

#[test]
fn a_loop_is_smooth_at_its_end() {
    let table = "time,shoulder\n0.2,0.3\n0.5,0.5\n0.8,0.1\n1.2,0.3\n";
    let folder = Folder::with(&[("m.csv", table)]);
    let task = "[[task]]\ntype = \"playback\"\nfile = \"m.csv\"\nloop = true\n";
    let commanded = commands(&folder, &format!("{PENDULUM}{task}"));
    // The fade is over after 0.5 s.
    for k in 500..3000 {
        let (a, b) = (&commanded[k], &commanded[k + 1000]);
        assert!((a.position[0] - b.position[0]).abs() < 1e-12 && (a.velocity[0] - b.velocity[0]).abs() < 1e-11, "{k}");
    }
    // The loop closes before 0.2 s too, so nothing jumps there. Jerks of some 300, accelerations of
    // 15. Those of the fade are about as large: 36 and 6 times some rad/s over 0.5 s, squared and
    // not.
    let (apart, step) = unsteadiness(&commanded, 0, &[]);
    assert!(apart < 1e-3 && step < 0.1, "{apart} {step}");
    let seams = unsteadiness(&commanded[500..], 0, &[]);
    assert!(seams.0 < 3e-4 && seams.1 < 0.03, "{seams:?}");
}

#[test]
fn only_the_joints_named_play() {
    let commanded = play("joints = [\"elbow\"]\nblend = 0");
    assert!(commanded.iter().all(|a| a.position[0] == 0.3));
    assert!((at(&commanded, 2.0).position[1] - 1.0).abs() < 1e-15);
}

#[test]
fn natural_ends_keep_their_velocity() {
    let commanded = play("ends = \"natural\"\nblend = 0");
    // The minimum-jerk curve through (0, 0.3), (1, 0.8), (2, -0.2) is the parabola.
    let parabola = |t: f64| 0.3 + 0.5 * t - 0.75 * t * (t - 1.0);
    for a in &commanded[..2000] {
        assert!((a.position[0] - parabola(a.time)).abs() < 1e-13, "{a:?}");
    }
    assert!((commanded[0].velocity[0] - 1.25).abs() < 1e-13);
    assert_eq!(at(&commanded, 2.1).velocity[0], 0.0);
}
