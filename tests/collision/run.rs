//! `[self_collision]` in a run: reported values against closed forms, and the effect of avoidance.

use crate::support::runs::Recording;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use stiction::assemble;
use stiction::robot;
use stiction::scenario;
use stiction::sim::{Metrics, Outcome, Simulation};

/// Boxes of 0.1 m on rails along x, each moved by a joint of the same name: name, x and y at 0.
type Boxes<'a> = &'a [(&'a str, f64, f64)];

/// Two on one rail, 0.5 m apart.
const TWO: Boxes = &[("a", -0.3, 0.0), ("b", 0.3, 0.0)];

fn urdf(boxes: Boxes) -> String {
    let mut text = String::from("<robot name=\"rail\"><link name=\"world\"/>\n");
    for (name, x, y) in boxes {
        let _ = write!(
            text,
            "<link name=\"box_{name}\"><inertial><mass value=\"1\"/>
              <inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>
              <collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision></link>
            <joint name=\"{name}\" type=\"prismatic\"><parent link=\"world\"/><child link=\"box_{name}\"/>
              <origin xyz=\"{x} {y} 0\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1000\" velocity=\"5\"/></joint>\n"
        );
    }
    text + "</robot>"
}

/// Joint `a` moves by `way` within 1 s and stays; both joints are kinematic.
fn text(way: f64, rest: &str) -> String {
    let mut text = String::from(
        "duration = 2.0\nrobot = { model = \"rail.toml\", contact = \"soles\" }\ncontrol = { rate = 1000 }\n",
    );
    text += "integrator = { method = \"semi-implicit\", step = 1e-3 }\n";
    let _ = writeln!(text, "task = [{{ type = \"posture\", duration = 1.0, joints = {{ a = {way} }} }}]\n{rest}");
    text
}

fn prepared(boxes: Boxes, text: &str) -> Result<Simulation, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("rail.urdf", &urdf(boxes));
    write("rail.toml", "urdf = \"rail.urdf\"\nbase = \"fixed\"\nkinematic = [\"*\"]\n");
    let file = scenario::parse(&folder.path().join("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let run = &file.expand(&[]).unwrap_or_else(|e| panic!("{e}"))[0];
    let robot = robot::load(&run.resolve(Path::new(&run.scenario.robot.model))).unwrap_or_else(|e| panic!("{e}"));
    let setup = assemble::setup(run, &robot).map_err(|e| e.to_string())?;
    Ok(Simulation::new(setup).unwrap_or_else(|e| panic!("{e}")))
}

fn run(text: &str) -> (Metrics, Recording) {
    run_with(TWO, text)
}

fn run_with(boxes: Boxes, text: &str) -> (Metrics, Recording) {
    let (mut sim, mut recorded) = (prepared(boxes, text).expect("it fits"), Recording::default());
    let (outcome, message) = sim.run(&mut recorded, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    (sim.metrics().clone(), recorded)
}

/// The minimum-jerk path.
fn path(t: f64) -> f64 {
    let s = t.clamp(0.0, 1.0);
    s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// Time at which the path reaches a value.
fn reached(value: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if path(middle) < value { low = middle } else { high = middle }
    }
    low
}

#[test]
fn reported_values_are_the_closed_form() {
    let (m, recorded) = run(&text(0.53, "self_collision = { method = 0, margin = 0.02 }"));
    // Overlap of 0.03 m at the end; GJK and EPA are good to 1e-10.
    assert!((m.min_self_distance_m.unwrap() + 0.03).abs() < 1e-9, "{:?}", m.min_self_distance_m);
    assert_eq!(m.self_collisions, Some(1));
    assert_eq!((m.avoidance_cycles, m.avoidance_rms_deviation), (None, None));
    // Detected at the ends of steps of 1 ms.
    let near = 2.0 - reached(0.48 / 0.53);
    assert!((m.self_near_s.unwrap() - near).abs() <= 1e-3, "{:?} {near}", m.self_near_s);
    let events: Vec<_> = recorded.events.iter().filter(|e| e.kind == "self-collision").collect();
    assert_eq!(events.len(), 1);
    let begins = reached(0.5 / 0.53);
    assert!(events[0].time >= begins && events[0].time <= begins + 1e-3 + 1e-9, "{} {begins}", events[0].time);
    assert_eq!(
        (events[0].subject.as_str(), events[0].message.as_str()),
        ("box_a/box_b", "overlap of `box_a` and `box_b` begins")
    );
    for s in &recorded.snapshots {
        let own = s.self_contact.as_ref().expect("self-collision is monitored");
        let (distance, pair, a, b) = own.nearest.expect("there is a pair");
        let truth = 0.5 + s.q[1] - s.q[0];
        assert!((distance - truth).abs() < 1e-9, "{distance} {truth}");
        assert_eq!(own.pairs[pair], ["box_a", "box_b"]);
        // The facing sides.
        assert!((a.x - (s.q[0] - 0.25)).abs() < 1e-9 && (b.x - (s.q[1] + 0.25)).abs() < 1e-9, "{a} {b}");
        assert!(own.frozen.is_empty() && own.desired.is_empty());
    }
}

#[test]
fn an_overlap_can_end_and_recur() {
    let posture = "{ type = \"posture\", duration = 1.0, joints = { a = 0 } }";
    let sine = "{ type = \"sine\", joints = { a = { amplitude = 0.6, frequency = 1.0 } } }";
    let text = text(0.0, "self_collision = { method = 0 }");
    let (m, recorded) = run(&text.replace(posture, sine).replace("duration = 2.0", "duration = 3.0"));
    let messages: Vec<&str> =
        recorded.events.iter().filter(|e| e.kind == "self-collision").map(|e| e.message.as_str()).collect();
    let (begins, ends) = ("overlap of `box_a` and `box_b` begins", "overlap of `box_a` and `box_b` ends");
    assert_eq!((messages, m.self_collisions), (vec![begins, ends, begins, ends], Some(2)));
}

#[test]
fn avoidance_keeps_the_margin_and_reports_its_cost() {
    for method in 1..=4 {
        let (m, recorded) = run(&text(0.53, &format!("self_collision = {{ method = {method}, margin = 0.02 }}")));
        let least = m.min_self_distance_m.unwrap();
        assert!(least >= 0.02 && m.self_collisions == Some(0) && m.self_near_s == Some(0.0), "{least}");
        assert_eq!(m.avoidance_cycles.unwrap() - m.avoidance_early_cycles.unwrap(), 20);
        assert!(m.avoidance_blocked_cycles.unwrap() > 5 && m.avoidance_tests_mean.unwrap() >= 1.0);
        let last = recorded.snapshots.last().unwrap();
        let own = last.self_contact.as_ref().unwrap();
        // The desired position is the task's; the command falls short of it. Joints that do not
        // move the pair are absent.
        assert!((own.desired[0] - 0.53).abs() < 1e-12 && own.desired[1] == 0.0, "{:?}", own.desired);
        assert!(last.q[0] < 0.48 + 1e-9, "{}", last.q[0]);
        assert!(m.avoidance_max_deviation.unwrap() >= 0.53 - last.q[0] - 1e-12);
        if method == 4 {
            // It approaches as long as it finds the motion worthwhile.
            assert!(last.q[0] > 0.45, "{}", last.q[0]);
        }
    }
    // A motion without obstacles is unchanged.
    let (m, _) = run(&text(0.3, "self_collision = { method = 2, margin = 0.02 }"));
    assert_eq!((m.avoidance_max_deviation, m.avoidance_blocked_cycles), (Some(0.0), Some(0)));
}

#[test]
fn a_start_within_the_margin_is_refused() {
    let refused = |text: &str| match prepared(TWO, text) {
        Ok(_) => String::new(),
        Err(message) => message,
    };
    let message = refused(&text(0.0, "self_collision = { method = 1, margin = 0.6 }"));
    assert!(message.contains("`box_a` and `box_b` start 0.5000 m apart"), "{message}");
    assert!(message.contains("self_collision") && message.contains("`ignore`"), "{message}");
    assert_eq!(refused(&text(0.0, "self_collision = { method = 0, margin = 0.6 }")), "");
}

#[test]
fn an_uncontrolled_joint_is_not_planned() {
    // b is passive and stays, whatever its command: a must not rely on it moving away.
    for method in 1..=4 {
        let text = text(0.9, &format!("self_collision = {{ method = {method}, margin = 0.02 }}"))
            .replace("joints = { a = 0.9 }", "joints = { a = 0.9, b = 0.9 }")
            .replace("contact = \"soles\"", "contact = \"soles\", joint = { b = { mode = \"passive\" } }");
        let (m, recorded) = run(&text);
        assert!(m.min_self_distance_m.unwrap() >= 0.02, "method {method}: {:?}", m.min_self_distance_m);
        let own = recorded.snapshots.last().unwrap().self_contact.as_ref().unwrap();
        assert!(own.frozen[0] && !own.frozen[1], "{:?}", own.frozen);
    }
}

#[test]
fn a_blocked_path_brakes() {
    // a moves slowly, for 5 s; b is pushed into its way and stays there.
    let boxes: Boxes = &[("a", -0.6, 0.0), ("b", 0.6, 0.0)];
    for method in 1..=4 {
        let (m, recorded) = run_with(
            boxes,
            &format!(
                "duration = 6.0
                robot = {{ model = \"rail.toml\", contact = \"soles\", joint = {{ b = {{ mode = \"velocity\", kd = 200.0 }} }} }}
                control = {{ rate = 1000 }}
                integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
                self_collision = {{ method = {method}, margin = 0.02, max_speed = 0.2 }}
                task = [{{ type = \"posture\", duration = 0.01, joints = {{ a = 0.9 }} }}]
                force = [{{ type = \"push\", link = \"box_b\", force = [-120, 0, 0], start = 0.5, duration = 1.0 }}]\n"
            ),
        );
        let there = recorded.snapshots.last().unwrap();
        assert!(there.q[1] < -0.5, "b has come to {}", there.q[1]);
        assert!(
            m.self_collisions == Some(0) && m.min_self_distance_m.unwrap() > 0.015,
            "{method}: {:?}",
            m.min_self_distance_m
        );
    }
}

#[test]
fn independent_pairs_do_not_stop_each_other() {
    // b stops a on one rail; c, on another one, is in d's way and moves out of it.
    let boxes: Boxes = &[("a", -0.3, 0.0), ("b", 0.3, 0.0), ("c", -0.3, 5.0), ("d", 0.3, 5.0)];
    let rest = "self_collision = { method = 2, margin = 0.02 }";
    let (m, recorded) = run_with(boxes, &text(0.9, rest).replace("{ a = 0.9 }", "{ a = 0.9, c = -0.2, d = -0.9 }"));
    let q = &recorded.snapshots.last().unwrap().q;
    assert!((q[2] + 0.2).abs() < 1e-9, "{q:?}");
    assert!(m.min_self_distance_m.unwrap() >= 0.02 && q[0] < 0.5 && q[3] > -0.7, "{q:?}");
}

#[test]
fn pairs_within_the_margin_may_only_move_apart() {
    // b drifts to 12 mm from a and stays there; a is commanded through b, and later away from it.
    let boxes: Boxes = &[("a", -0.3, 0.0), ("b", 0.3, 0.0), ("c", 0.0, 5.0)];
    let text = |to: f64| {
        format!(
            "duration = 4.0
            robot = {{ model = \"rail.toml\", contact = \"soles\", joint = {{ b = {{ mode = \"velocity\", kd = 200.0 }} }} }}
            control = {{ rate = 1000 }}
            integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
            self_collision = {{ method = 2, margin = 0.02 }}
            force = [{{ type = \"push\", link = \"box_b\", force = [-195.2, 0, 0], duration = 0.5 }}]
            # c has zero to do with them, and is slow: only the pair's own motion must count.
            task = [
                {{ type = \"posture\", start = 1.0, duration = 1.0, joints = {{ a = {to} }} }},
                {{ type = \"posture\", start = 1.0, duration = 2.5, joints = {{ c = 0.9 }} }},
            ]\n"
        )
    };
    let (m, recorded) = run_with(boxes, &text(0.9));
    let near = recorded.snapshots.iter().map(|s| 0.5 + s.q[1] - s.q[0]).fold(f64::INFINITY, f64::min);
    assert!(near > 0.005 && near < 0.02, "{near}");
    assert_eq!(m.self_collisions, Some(0));
    let at = |t: f64, recorded: &Recording| recorded.snapshots.iter().find(|s| s.time >= t).unwrap().q[0];
    assert!((recorded.snapshots.last().unwrap().q[0] - at(1.0, &recorded)).abs() < 1e-9);
    let (m, recorded) = run_with(boxes, &text(-0.5));
    assert!((recorded.snapshots.last().unwrap().q[0] + 0.5).abs() < 1e-9 && m.self_collisions == Some(0));
}

#[test]
fn unpredicted_motion_triggers_an_early_cycle() {
    // One cycle a second. At the first one a is at rest; by the next one it would long overlap b,
    // within all limits.
    for method in 1..=4 {
        let rest = format!("self_collision = {{ method = {method}, margin = 0.02, rate = 1.0 }}");
        let (m, _) = run(&text(0.9, &rest).replace("duration = 1.0", "start = 0.2, duration = 0.6"));
        assert!(m.min_self_distance_m.unwrap() >= 0.02, "method {method}: {:?}", m.min_self_distance_m);
        assert!(m.avoidance_early_cycles.unwrap() >= 1, "method {method}");
    }
}
