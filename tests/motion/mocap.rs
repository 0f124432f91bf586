//! `mocap`: retargeting, limits and resampling.

use super::{Folder, PENDULUM, TickCommand, commands, unsteadiness};
use std::fs;
use std::path::Path;

const BVH: &str = "HIERARCHY
ROOT Body
{
  OFFSET 0 0 0
  CHANNELS 3 Xposition Xrotation Yrotation
  End Site
  {
    OFFSET 0 1 0
  }
}
MOTION
Frames: 3
Frame Time: 0.5
0 0 0
100 90 10
0 0 20
";

fn follow(file: (&str, &str), task: &str) -> Vec<TickCommand> {
    let text = format!("{PENDULUM}[[task]]\ntype = \"mocap\"\nfile = \"{}\"\n{task}\n", file.0);
    commands(&Folder::with(&[file]), &text)
}

const PLAIN: &str = "blend = 0\nsmoothing = 0\n";

#[test]
fn channels_become_joints_by_name_sign_and_offset() {
    let map = "map = { \"Body.Xrotation\" = { joint = \"elbow\", scale = -1, offset = \"10 deg\" }, \"Body.Yrotation\" = { joint \
               = \"shoulder\", scale = 0.5 } }";
    let commanded = follow(("m.bvh", BVH), &format!("start = 0.25\n{PLAIN}{map}"));
    for a in &commanded {
        let t = (a.time - 0.25).clamp(0.0, 1.0);
        let (x, y) = (180.0 * if t < 0.5 { t } else { 1.0 - t }, 20.0 * t);
        let expected =
            if a.time < 0.25 - 1e-9 { [0.3, -0.2] } else { [(0.5 * y).to_radians(), (10.0 - x).to_radians()] };
        for (got, expected) in a.position.iter().zip(expected) {
            // Roundings of a sum of angles of some 1.5 rad.
            assert!((got - expected).abs() < 1e-14, "{a:?} {expected}");
        }
    }
    assert_eq!(commanded[4000].velocity, [0.0, 0.0]);
    // 10 deg/s at half scale; central differences of a straight line.
    assert!((commanded[600].velocity[0] - 10f64.to_radians()).abs() < 1e-12);
}

#[test]
fn tables_need_no_skeleton() {
    let commanded = follow(
        ("m.csv", "time,a b\n0,0\n1,2\n"),
        &format!("speed = 0.5\n{PLAIN}map = {{ \"a b\" = {{ joint = \"elbow\" }} }}"),
    );
    for a in &commanded {
        assert!((a.position[1] - a.time.min(2.0)).abs() < 1e-14, "{a:?}");
    }
}

#[test]
fn limited_speeds_are_reported() {
    let folder = Folder::with(&[("m.csv", "time,a\n0,0\n1,0\n1.2,1\n2.2,1\n")]);
    let text = |smoothing: f64| {
        format!(
            "{}[[task]]\ntype = \"mocap\"\nfile = \"m.csv\"\nspeed_limit = 2\nblend = 0\nsmoothing = {smoothing}\nmap = {{ a = {{ joint = \"elbow\" \
             }} }}\n",
            PENDULUM.replace(
                "posture = { shoulder = 0.3, elbow = -0.2 }",
                "soles = [], joint_default = { mode = \"passive\" }"
            )
        )
    };
    for smoothing in [0.0, 0.12] {
        let commanded = commands(&folder, &text(smoothing));
        let fastest = commanded.iter().map(|a| a.velocity[1].abs()).fold(0.0, f64::max);
        assert!(fastest <= 2.0 + 1e-10, "{fastest}");
        assert!(commanded.iter().all(|a| (-1e-12..=1.0 + 1e-12).contains(&a.position[1])));
        assert!((commanded[1100].position[1] - 0.5).abs() < 1e-12, "the middle of the move does not move");
        let (apart, step) = unsteadiness(&commanded, 1, &[]);
        // Smoothed over 0.12 s, a step of the speed of 2 rad/s takes three averages over 41 ms
        // each: at most 3/4 of it, 1.5 rad/s, within 41 ticks.
        assert!(apart < 1e-9 && (smoothing == 0.0 || step < 1.1 * 1.5 / 41.0), "{apart} {step}");
    }
    // 5 rad/s for 0.2 s against 2 rad/s: half of the excess, (1 - 0.4) / 2, at any smoothing.
    let (_, _, notes) = folder.watch(&text(0.0).replace("duration = 4.0", "duration = 2.3"));
    assert!(
        notes[0].contains("speed limit of 2 rad/s of `elbow` changed") && notes[0].ends_with("by up to 0.3000 rad"),
        "{notes:?}"
    );
    assert!(notes.len() == 2 && notes[1].contains("`elbow` is in mode `passive`"), "{notes:?}");
}

#[test]
fn limited_ranges_are_reported() {
    let table = "time,k\n0,0.7\n1,3.0\n2,0.7\n";
    let folder = Folder::with(&[("m.csv", table)]);
    let text = "duration = 0.1\nrobot = { model = \"ROBOTS/hoap2/hoap2.toml\" }\n[[task]]\ntype = \"mocap\"\nfile = \
                \"m.csv\"\nblend = 0\nmap = { k = { joint = \"left_knee\" } }\n";
    // Commands do not depend on the end of the run.
    let (_, _, notes) = folder.watch(text);
    assert_eq!(notes.len(), 1, "{notes:?}");
    let run = folder.run(&text.replace("duration = 0.1", "duration = 3")).unwrap();
    let setup = stiction::assemble::setup(&run, &super::robot_of(&run)).unwrap();
    let knee = setup.model.joint("left_knee").unwrap();
    let upper = setup.model.joints[knee.0].upper;
    // The last frames at 2.3 rad/s are slower than the joint's 5 rad/s.
    assert_eq!(setup.notes.len(), 1, "{:?}", setup.notes);
    assert!(setup.notes[0].contains(&format!("by up to {:.4} rad", 3.0 - upper)));
    let commanded = commands(&folder, &text.replace("duration = 0.1", "duration = 3"));
    let most = commanded.iter().map(|a| a.position[knee.0]).fold(0.0, f64::max);
    assert!(most <= upper && most > upper - 1e-12, "{most} {upper}");
}

#[test]
fn commands_do_not_depend_on_the_end_of_the_run() {
    // Faster than allowed right after 0.5 s: the nearest motion within the speed limit begins
    // before that.
    let folder = Folder::with(&[("m.csv", "time,a\n0,0\n0.51,0\n0.6,2\n2,0\n")]);
    let text = format!(
        "{PENDULUM}[[task]]\ntype = \"mocap\"\nfile = \"m.csv\"\nspeed_limit = 3\nmap = {{ a = {{ joint = \"elbow\" }} }}\n"
    );
    let (short, long) =
        (commands(&folder, &text.replace("duration = 4.0", "duration = 0.5")), commands(&folder, &text));
    assert!(short[500].position[1] > 0.01 && short.len() == 501);
    assert!(short.iter().zip(&long).all(|(a, b)| a.position == b.position && a.velocity == b.velocity));
}

#[test]
fn motions_are_smoothed_at_low_rates_too() {
    // A corner of 1 rad/s at 1 s, averaged three times over w = smoothing / 3, is rounded by the
    // mean of |x| under three boxes of width w: 13/32 w (density 3/4 - x^2 up to 1/2, (3/2 - |x|)^2
    // / 2 up to 3/2, in units of w).
    let follow = |rate: f64, smoothing: f64| {
        let task = format!(
            "blend = 0\nsmoothing = {smoothing}\nmap = {{ a = {{ joint = \"elbow\" }} }}\n[control]\nrate = {rate}"
        );
        let commanded = follow(("m.csv", "time,a\n0,0\n1,1\n2,0\n"), &task);
        commanded[rate as usize].position[1]
    };
    let closed = 1.0 - 13.0 / 32.0 * 0.2;
    assert!((follow(1000.0, 0.6) - closed).abs() < 1e-3, "{} {closed}", follow(1000.0, 0.6));
    for rate in [25.0, 10.0, 5.0] {
        // Windows of whole samples, 6 or 7 of them.
        assert!((1.0 - follow(rate, 0.6) - 13.0 / 32.0 * 0.2).abs() < 0.2 * 0.081, "{rate}: {}", follow(rate, 0.6));
    }
    assert_eq!(follow(5.0, 0.0), 1.0);
}

#[test]
fn the_example_motion_is_valid() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/motions/wave.bvh")).unwrap();
    let motion = stiction::motion::bvh::read(&text).unwrap();
    assert!(motion.tracks.len() > 5 && motion.span().unwrap().1 > 2.0);
}
