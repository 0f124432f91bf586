//! Changes to balance settings during the task.
//!
//! A slide of mass b moves up and down on a foot of mass a. With zero joint gains the task commands
//! the slide `tau = J_c^T F`, with `J_c = b / (a + b)` its Jacobian of the centre of mass. The
//! efforts are constant over ticks of length T, which acts as if damping were reduced by `kp T /
//! 2`. The displacement x from the reference then obeys
//!
//! ```text
//! x'' = - b / (a + b) (kp x + kd x')
//! ```

use super::standing::HOAP;
use crate::support::runs::{run, watch};
use nalgebra::Vector3;
use std::fs;
use tempfile::TempDir;

const A: f64 = 3.0;
const B: f64 = 1.0;
const RATE: f64 = 10_000.0;

struct Slide(TempDir);

impl Slide {
    fn new() -> Self {
        let inertial = |m: f64| {
            let i = 0.01 * m;
            format!(
                "<inertial><mass value=\"{m}\"/><inertia ixx=\"{i}\" ixy=\"0\" ixz=\"0\" iyy=\"{i}\" iyz=\"0\" izz=\"{i}\"/></inertial>"
            )
        };
        let urdf = format!(
            "<robot name=\"slide\"><link name=\"foot\">{}</link><link name=\"cart\">{}</link>\
             <joint name=\"slide\" type=\"prismatic\"><origin xyz=\"0 0 0.1\"/><parent link=\"foot\"/><child link=\"cart\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1000\" velocity=\"100\"/></joint></robot>",
            inertial(A),
            inertial(B)
        );
        let folder = TempDir::new().expect("a folder for the robot");
        fs::write(folder.path().join("slide.urdf"), urdf).expect("the folder is writable");
        Slide(folder)
    }

    /// Times, positions and velocities of the slide.
    fn watch(&self, duration: f64, velocity: f64, task: &str) -> Vec<(f64, f64, f64)> {
        let polygon = "[[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]]";
        let (_, recorded) = watch(&format!(
            "duration = {duration}\nlog = {{ rate = 100.0 }}\ncontrol = {{ rate = {RATE} }}
            [robot]\nmodel = {:?}\njoint_default = {{ mode = \"force\" }}\nvelocity = {{ slide = {velocity} }}
            soles = [{{ name = \"sole\", link = \"foot\", polygon = {polygon} }}]\n[[task]]\n{task}",
            self.0.path().join("slide.urdf")
        ));
        recorded.snapshots.iter().map(|s| (s.time, s.q[0], s.qd[0])).collect()
    }
}

#[test]
fn new_gains_change_the_frequency_of_the_closed_loop() {
    let (kp, kd, step) = (900.0, 4.0, 0.004);
    let recorded = Slide::new().watch(
        1.6,
        0.0,
        &format!(
            "type = \"balance\"\ncontrol = \"force\"\nforce = {{ joints = {{ kp = 0, kd = 0 }} }}
            change = [{{ at = 0.6, force = {{ com = {{ kp = {kp}, kd = {kd} }}, offset = [0, 0, {step}], approach = 0 }} }}]"
        ),
    );
    // The centre of mass rises by `step`, the slide by (a + b) / b times as much.
    let way = step * (A + B) / B;
    let part = B / (A + B);
    let damping = 0.5 * part * (kd - 0.5 * kp / RATE);
    let w = (part * kp - damping * damping).sqrt();
    let mut turns = 0;
    for (t, x, v) in recorded {
        let t = t - 0.6;
        if t <= 0.0 {
            // At rest in an exact equilibrium before.
            assert!(x.abs() < 1e-9 && v.abs() < 1e-9, "{t} {x:e} {v:e}");
            continue;
        }
        let truth = way * (1.0 - (-damping * t).exp() * ((w * t).cos() + damping / w * (w * t).sin()));
        // Terms of second order in the tick, (w T)^2 / 24 of the frequency over 15 rad: 1e-6 of the
        // distance; integration at 1e-6.
        assert!((x - truth).abs() < 3e-4 * way, "{t} {x} {truth}");
        turns += usize::from(x > 1.5 * way);
    }
    assert!(turns > 3, "it overshoots: {turns}");
}

#[test]
fn gravity_compensation_changes_its_damping() {
    let (v0, first, then) = (0.4, 3.0, 9.0);
    let recorded = Slide::new().watch(
        0.5,
        v0,
        &format!("type = \"gravity-compensation\"\ndamping = {first}\nchange = [{{ at = 0.2, damping = {then} }}]"),
    );
    for (t, _, v) in recorded {
        // Over each tick the velocity decreases by the fraction kd T.
        let ticks = |t: f64, kd: f64| (1.0 - kd / RATE).powf(t * RATE);
        let truth = v0 * ticks(t.min(0.2), first) * ticks((t - 0.2).max(0.0), then);
        // Integration at 1e-6.
        assert!((v - truth).abs() < 1e-6, "{t} {v} {truth}");
    }
}

#[test]
fn the_centre_of_mass_reaches_a_new_offset_without_jumps() {
    let text = |more: &str| {
        let gains = "approach = 0.5, com = { kp = 400, kd = 80 }, joints = { kp = 25, kd = 5 }";
        let task = format!("[[task]]\ntype = \"balance\"\ncontrol = \"force\"\nforce = {{ {gains} }}\n{more}\n");
        let robot = HOAP.replace("3.0", "9.0").replace(" }", ", joint_limits = \"ignore\" }");
        format!("{robot}{task}[log]\nrate = 1000.0\n[integrator]\nmethod = \"semi-implicit\"\n")
    };
    let (_, still) = watch(&text(""));
    // The second change arrives while the robot moves to the first offset.
    let (m, moved) = watch(&text(
        "change = [{ at = 2.0, force = { offset = [0.02, 0, 0] } },
                   { at = 2.25, force = { offset = [0.005, -0.01, 0.004], approach = 1.0 } }]",
    ));
    let end = |recorded: &crate::support::runs::Recording| recorded.snapshots.last().expect("the end").com;
    // The remaining error is 6e-6 m in height, 0.02 N of a weight of 70 N, with and without the
    // springs of the joints. With end stops, a joint pressed against one by its spring would leave
    // 3e-5 m.
    assert!(
        (end(&moved) - end(&still) - Vector3::new(0.005, -0.01, 0.004)).norm() < 1e-5,
        "{} {}",
        end(&moved),
        end(&still)
    );
    assert_eq!((m.state_changes, m.inconsistent), (0, 0));
    // From tick to tick, efforts change as much as on the rest of the way. A reference that jumped
    // by the 10 mm between the two goals would change some by m kp 0.01 times a lever of some 0.2
    // m, 6 N m.
    let jump = |from: f64, to: f64| {
        let within = moved.snapshots.windows(2).filter(|w| w[0].time >= from && w[1].time <= to);
        within.flat_map(|w| w[0].effort.iter().zip(&w[1].effort).map(|(a, b)| (a - b).abs())).fold(0.0, f64::max)
    };
    let (at_changes, between) = (jump(1.998, 2.002).max(jump(2.248, 2.252)), jump(2.002, 2.248));
    assert!(at_changes < 1.5 * between && between < 0.2, "{at_changes} {between}");
}

#[test]
fn a_list_of_changes_lowers_the_gains() {
    let push = "[[force]]\ntype = \"push\"\nlink = \"torso\"\nforce = [6.0, 0, 0]\nstart = 1.0\nduration = 0.1\n";
    let back = |change: &str| {
        let task = format!("[[task]]\ntype = \"balance\"\ncontrol = \"force\"\nforce = {{ approach = 0.2 }}\n{change}");
        run(&format!("{HOAP}{task}\n{push}")).final_base_position[0]
    };
    let (stiff, loose) = (
        back(""),
        back(
            "change = [{ at = 0.9, force = { com = { kp = 0, kd = 1 }, orientation = { kp = 0, kd = 1 },
                                             joints = { kp = 0, kd = 2 } } }]",
        ),
    );
    assert!((stiff - loose).abs() > 0.02, "{stiff} {loose}");
}
