//! The stepping loop allocates nothing, with any task, force, sensor and estimator.
//!
//! Steps and ticks with an event (a task begins or ends, a contact changes) are not counted,
//! because they allocate its message. Scripts allocate tables in Luau's own heap, which counts as
//! well: see the last test.

use crate::analytic::imu::{HEAD, HOAP2, with};
use crate::support::counting::{balance, count};
use crate::support::runs::simulation;
use std::fmt::Write;
use stiction::scenario::schema;
use stiction::sim::{NullObserver, Observer, SimEvent, Simulation, Snapshot};

/// A task or force with which HOAP-2 is stepped: its entry without `type`.
struct Part {
    kind: &'static str,
    name: &'static str,
    entry: &'static str,
    /// Time from which on allocations are counted, s, and for how long.
    window: (f64, f64),
}

const fn part(kind: &'static str, name: &'static str, window: (f64, f64), entry: &'static str) -> Part {
    Part { kind, name, entry, window }
}

const PARTS: &[Part] = &[
    part("task", "posture", (0.1, 0.3), "duration = 1.0\njoints = { left_elbow = -1.0 }"),
    part(
        "task",
        "sine",
        (0.3, 0.3),
        "joints = { head_pan = { amplitude = 0.3, frequency = 2.0 } }
         change = [{ at = 0.2, joints = { head_pan = { amplitude = 0.1, frequency = 1.0 } } }]",
    ),
    part("task", "playback", (0.3, 0.3), "file = \"scenarios/motions/bow.toml\"\nchange = [{ at = 0.2, speed = 0.5 }]"),
    part(
        "task",
        "mocap",
        (0.3, 0.3),
        "file = \"scenarios/motions/wave.bvh\"\nmap = { \"LeftArm.Zrotation\" = { joint = \"left_shoulder_roll\" } }",
    ),
    part(
        "task",
        "balance",
        (0.3, 0.3),
        "control = \"force\"\nforce = { contacts = \"sensed\" }
         change = [{ at = 0.2, force = { offset = [0.005, 0, 0], com = { kp = 50, kd = 15 } } }]",
    ),
    part(
        "task",
        "balance",
        (0.3, 0.3),
        "control = \"position\"\nposition = { integral = 1 }
         change = [{ at = 0.2, position = { offset = [0.005, 0], leaning = 1 } }]",
    ),
    part("task", "gravity-compensation", (0.1, 0.2), "change = [{ at = 0.05, damping = 1 }]"),
    part("task", "squat", (0.5, 0.3), "depth = 0.02\nsettle = 0.4\nperiod = 1.0"),
    // Covers lifting, swinging and setting down of the first foot.
    part("task", "walk", (1.2, 1.2), "steps = 2\nstep_length = 0.02\nwait = 0.8\nsettle = 0.4"),
    part("force", "push", (0.1, 0.2), "link = \"torso\"\nforce = [3, 1, 0]\nduration = 5.0\nprofile = \"half-sine\""),
    part("force", "constant", (0.1, 0.2), "end_effector = \"left_hand\"\nforce = [1, 0, 0]\nframe = \"link\""),
    part("force", "ramp", (0.1, 0.2), "link = \"torso\"\nforce = [2, 0, 0]\nduration = 5.0"),
    part(
        "force",
        "spring",
        (0.1, 0.2),
        "link = \"torso\"\nstiffness = 20.0\ndamping = 1.0
         anchor = { waypoints = [{ at = 0, position = [0, 0, 0.3] }, { at = 4, position = [0.01, 0, 0.3] }] }",
    ),
    part(
        "force",
        "random-pushes",
        (0.1, 0.3),
        "links = [\"torso\"]\nnumber = 20\nmagnitude = [0.1, 0.2]\npush_duration = [0.5, 1]",
    ),
    part("force", "drag", (0.1, 0.2), "linear = 0.1\nquadratic = 0.1\nwind = [1, 0, 0]"),
    part(
        "force",
        "carried-object",
        (0.1, 0.2),
        "end_effector = \"right_hand\"\nmass = 0.1\nstart = 0.05\nvelocity = [0, 0, 0]",
    ),
    part("force", "joint-friction", (0.1, 0.2), "all = { coulomb = 0.01, static = 0.02 }"),
];

/// Types counted elsewhere in this file.
const SCRIPTS: [&str; 2] = ["task script", "force script"];
/// Counted in `policy/allocations.rs`, if the program has networks.
const NETWORK: &str = "task policy";

const ADAPTIVE: &str = "method = \"dopri5\"";
const FIXED: &str = "method = \"semi-implicit\"\nstep = 1e-3";

fn hoap2(model: &str, integrator: &str, more: &str) -> String {
    format!(
        "duration = 5.0\nlog = {{ rate = 200.0 }}\nrobot = {{ model = {model} }}\n[integrator]\n{integrator}\n{more}\n"
    )
}

/// Counts events.
#[derive(Default)]
struct EventCounter {
    events: usize,
}

impl Observer for EventCounter {
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), stiction::sim::ObserverError> {
        Ok(())
    }

    fn event(&mut self, _: &SimEvent) -> Result<(), stiction::sim::ObserverError> {
        self.events += 1;
        Ok(())
    }
}

fn step(sim: &mut Simulation, counter: &mut EventCounter) {
    sim.step(counter).unwrap_or_else(|stop| panic!("{stop:?}"));
}

fn until(sim: &mut Simulation, time: f64) {
    while sim.plant().state.time < time {
        step(sim, &mut EventCounter::default());
    }
}

/// Steps through the window; returns the number of steps without events, and the allocations in
/// them.
fn quiet(text: &str, (from, length): (f64, f64)) -> (usize, usize) {
    let mut sim = simulation(text);
    sim.begin(&mut NullObserver).unwrap_or_else(|stop| panic!("{stop:?}"));
    until(&mut sim, from);
    let (mut steps, mut allocations) = (0, 0);
    while sim.plant().state.time < from + length {
        let mut counter = EventCounter::default();
        let allocated = count(|| step(&mut sim, &mut counter));
        if counter.events == 0 {
            steps += 1;
            allocations += allocated;
        }
    }
    (steps, allocations)
}

#[test]
fn every_task_and_every_force_steps_without_allocating() {
    let model = format!("\"{HOAP2}.toml\"");
    let mut wrong = String::new();
    for Part { kind, name, entry, window } in PARTS {
        for integrator in [ADAPTIVE, FIXED] {
            let text = hoap2(&model, integrator, &format!("[[{kind}]]\ntype = \"{name}\"\n{entry}"));
            let length = if integrator == ADAPTIVE { window.1.min(0.6) } else { window.1 };
            let (steps, allocations) = quiet(&text, (window.0, length));
            assert!(steps > 10, "{kind} {name}: {steps} steps without an event");
            if allocations > 0 {
                let _ = writeln!(wrong, "{kind} {name}, {integrator}: {allocations} allocations in {steps} steps");
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A type that is added to the format must be added here.
#[test]
fn no_type_is_left_out() {
    let schema = schema();
    for (definition, kind) in [("TaskSpec", "task"), ("ForceSpec", "force")] {
        let types = schema["$defs"][definition]["oneOf"].as_array().expect("types");
        for entry in types {
            let name = entry["properties"]["type"]["const"].as_str().expect("a word");
            let stepped = PARTS.iter().any(|p| (p.kind, p.name) == (kind, name));
            let full_name = format!("{kind} {name}");
            assert!(stepped || full_name == NETWORK || SCRIPTS.contains(&full_name.as_str()), "{full_name}");
        }
    }
}

#[test]
fn sensors_and_estimators_allocate_nothing() {
    let (_folder, model) = with(&format!("{HOAP2}.toml"), &format!("{HOAP2}.urdf"), HEAD);
    let sensors = "[sensors]\nimu = \"head\"
        joint_position = { noise = 1e-5, bias = 1e-5, resolution = 1e-5, delay = 0.0035 }
        joint_velocity = { delay = 0.002 }\njoint_load = { noise = 1e-3 }
        orientation = { noise = 1e-4, bias = [0.001, 0, 0], delay = 0.002 }\ngyroscope = { noise = 1e-4 }
        accelerometer = { delay = 0.002 }\nsole_force = { noise = 0.1, delay = 0.002 }\nsole_moment = { resolution = 1e-4 }";
    for estimator in [
        "estimator = \"truth\"",
        "estimator = \"kinematic\"",
        "estimator = \"kinematic\"\nkinematic = { static_soles = [\"left\"] }",
        "estimator = \"inertial\"",
        "estimator = \"inertial\"\ninertial = { acceleration = \"soles\" }",
    ] {
        for integrator in [ADAPTIVE, FIXED] {
            // The task requests all data that are computed from the readings of the soles.
            let task = "[[task]]\ntype = \"balance\"\ncontrol = \"position\"";
            let text = hoap2(&model, integrator, &format!("{task}\n{sensors}\n[control]\n{estimator}"));
            let (steps, allocations) = quiet(&text, (0.05, 0.1));
            assert!(steps > 50, "{steps}");
            assert_eq!(allocations, 0, "{estimator} {integrator}");
        }
    }
}

const TASK: &str = "
local knee, start
function init(robot, params) knee = robot.joint.left_knee; start = robot.q[knee] end
needs = { 'com', 'com_jacobian', 'zmp', 'soles' }
function run(robot)
    local c = robot.com
    robot.set_position(knee, start + 0.01 * math.sin(robot.time) + 0 * c[1])
end";

const FORCE: &str = "
links = { 'torso' }
function run(robot)
    local v = robot.link.torso.linear_velocity
    return { { link = 'torso', point = { 0, 0, 0.1 }, force = { -2 * v[1], 0, 0 } } }
end";

/// Closed loops and couplings, with contact, in both steppers.
#[test]
fn closed_loops_and_couplings_allocate_nothing() {
    for integrator in ["", "integrator = { method = \"semi-implicit\", step = 1e-3 }"] {
        let ankle = format!("duration = 2.0\n{integrator}\nrobot.model = \"robots/ankle/ankle.toml\"\n");
        let gripper = format!(
            "duration = 2.0\nfloor.plane = false\n{integrator}\n[robot]\nmodel = \"robots/gripper/gripper.toml\"\n\
             joint = {{ lift = {{ mode = \"kinematic\" }} }}\n"
        );
        for text in [ankle, gripper] {
            let (steps, allocations) = quiet(&text, (0.3, 0.3));
            assert!(steps > 0 && allocations == 0, "{allocations} allocations in {steps} steps\n{text}");
        }
    }
}

/// Scripts allocate in Luau's heap, which its collector empties, so the memory in use does not grow
/// with time. Otherwise a task allocates nothing. A force, whose `run` returns tables, may make a
/// few small allocations in each call.
#[test]
fn scripts_hold_no_more_memory_from_tick_to_tick() {
    let model = format!("\"{HOAP2}.toml\"");
    let folder = tempfile::tempdir().expect("a folder for scripts");
    for ((name, text), a_call) in SCRIPTS.into_iter().zip([TASK, FORCE]).zip([0, 6]) {
        let kind = name.split(' ').next().expect("a word");
        let file = folder.path().join(format!("{kind}.luau"));
        std::fs::write(&file, text).expect("the folder is writable");
        let entry = format!("[[{kind}]]\ntype = \"script\"\nfile = {file:?}");
        for integrator in [ADAPTIVE, FIXED] {
            let mut sim = simulation(&hoap2(&model, integrator, &entry));
            sim.begin(&mut NullObserver).expect("it begins");
            until(&mut sim, 0.5);
            let calls = |sim: &Simulation| sim.plant().evaluations as usize;
            let before = calls(&sim);
            let mut allocated = 0;
            let more = (0..4).map(|k| balance(|| allocated += count(|| until(&mut sim, 0.75 + 0.25 * f64::from(k)))));
            let grown: Vec<isize> = more.collect();
            let calls = calls(&sim) - before;
            println!(
                "{name}, {integrator}: {allocated} allocations in {calls} evaluations, bytes more held: {grown:?}"
            );
            // The heap grows and shrinks by pages of 16 KiB.
            assert!(allocated <= a_call * calls + 20, "{name}: {allocated} in {calls}");
            assert!(grown.iter().sum::<isize>() < 100_000, "{name}: {grown:?}");
        }
    }
}
