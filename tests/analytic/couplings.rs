//! Coupled joints by closed forms: two pendulums of which one follows the other, and a gripper.

use super::body::G;
use super::object_models::File;
use crate::support::runs::{Recording, finish, rk4, simulation, watch};
use stiction::sim::NullObserver;

/// Pendulums about y from two pivots: mass, distance of its centre, moment of inertia about the pivot.
const FIRST: (f64, f64, f64) = (1.0, 0.25, 0.08);
const SECOND: (f64, f64, f64) = (0.6, 0.2, 0.03);
/// The second follows: `q2 = K q1 + C`.
const K: f64 = -1.6;
const C: f64 = 0.4;

fn pendulums() -> File {
    let link = |name: &str, (mass, distance, inertia): (f64, f64, f64)| {
        let own = inertia - mass * distance * distance;
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 {}\"/><mass value=\"{mass}\"/>
             <inertia ixx=\"{own}\" iyy=\"{own}\" izz=\"{own}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>",
            -distance
        )
    };
    let joint = |name: &str, at: f64, inside: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"world\"/><child link=\"{name}\"/>
             <origin xyz=\"{at} 0 1\"/><axis xyz=\"0 1 0\"/>{inside}</joint>"
        )
    };
    File::new(
        "pendulums.urdf",
        &format!(
            "<robot name=\"pendulums\"><link name=\"world\"/>{}{}{}{}</robot>",
            link("first", FIRST),
            link("second", SECOND),
            joint("second", 0.0, &format!("<mimic joint=\"first\" multiplier=\"{K}\" offset=\"{C}\"/>")),
            joint("first", 1.0, ""),
        ),
    )
}

/// `(I1 + K^2 I2) q1'' = -m1 g l1 sin q1 - K m2 g l2 sin q2`
fn acceleration(q: f64) -> f64 {
    let ((m1, l1, i1), (m2, l2, i2)) = (FIRST, SECOND);
    (-m1 * G * l1 * q.sin() - K * m2 * G * l2 * (K * q + C).sin()) / (i1 + K * K * i2)
}

#[test]
fn a_following_joint_follows_and_transmits_its_load() {
    let (file, duration) = (pendulums(), 3.0);
    let mut recording = Recording::default();
    let mut sim = simulation(&format!(
        "duration = {duration}
            floor.plane = false
            integrator = {{ relative_tolerance = 1e-12, absolute_tolerance = 1e-13 }}
            log.rate = 100
            [robot]
            model = {:?}
            joint_default = {{ mode = \"passive\" }}
            posture = {{ first = 0.7 }}
            velocity = {{ first = -2.0 }}\n",
        file.path()
    ));
    let metrics = finish(&mut sim, &mut recording);
    // Accumulated error of integration; no force does work.
    assert!(metrics.max_energy_error_j < 1e-9, "{}", metrics.max_energy_error_j);
    assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-14), "{:?}", metrics.max_loop_error_m);
    let plant = sim.plant();
    let [first, second] = ["first", "second"].map(|name| plant.model.joint(name).expect("a joint").0);
    let truth = rk4([0.7, -2.0], duration, 200_000, |_, s| [s[1], acceleration(s[0])]);
    // Integration at 1e-12 over some hundred steps of a swinging pendulum.
    assert!((plant.state.joints[first] - truth[0]).abs() < 1e-9, "{} {}", plant.state.joints[first], truth[0]);
    assert!((plant.state.v[first] - truth[1]).abs() < 1e-9);
    // Logged states are on the coupling too, with the effort that moves the following pendulum:
    // I2 q2'' + m2 g l2 sin q2 = effort.
    let (m2, l2, i2) = SECOND;
    assert!(recording.snapshots.len() > 290);
    for snapshot in &recording.snapshots {
        let (q1, q2) = (snapshot.q[first], snapshot.q[second]);
        let effort = i2 * K * acceleration(q1) + m2 * G * l2 * q2.sin();
        let (logged, error) = snapshot.couplings[0];
        assert!(error.abs() < 1e-14 && (q2 - (K * q1 + C)).abs() < 1e-14, "{error}");
        assert!((snapshot.qd[second] - K * snapshot.qd[first]).abs() < 1e-13);
        // Rounding.
        assert!((logged - effort).abs() < 1e-12, "{logged} {effort} at {}", snapshot.time);
    }
}

/// A step of length h has an error O(h) in the motion, but none in the coupling.
#[test]
fn velocity_level_steps_converge_on_the_coupling() {
    let file = pendulums();
    let truth = rk4([0.7, -2.0], 1.0, 100_000, |_, s| [s[1], acceleration(s[0])]);
    let error = |step: f64| {
        let mut sim = simulation(&format!(
            "duration = 1.0
            floor.plane = false
            integrator = {{ method = \"semi-implicit\", step = {step} }}
            [robot]
            model = {:?}
            joint_default = {{ mode = \"passive\" }}
            posture = {{ first = 0.7 }}
            velocity = {{ first = -2.0 }}\n",
            file.path()
        ));
        let metrics = finish(&mut sim, &mut NullObserver);
        assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-14), "{:?}", metrics.max_loop_error_m);
        let first = sim.plant().model.joint("first").expect("a joint").0;
        (sim.plant().state.joints[first] - truth[0]).abs()
    };
    let (coarse, fine) = (error(1e-3), error(5e-4));
    // First order; terms of second order remain.
    assert!((coarse / fine - 2.0).abs() < 0.05 && coarse < 2e-3, "{coarse} {fine}");
}

/// A kinematic leader takes its follower with it; its drive carries both.
#[test]
fn a_kinematic_leader_moves_its_follower() {
    let file = pendulums();
    for integrator in ["{ relative_tolerance = 1e-10 }", "{ method = \"semi-implicit\", step = 1e-3 }"] {
        let (metrics, recording) = watch(&format!(
            "duration = 2.0
            floor.plane = false
            integrator = {integrator}
            log.rate = 50
            task = [{{ type = \"posture\", start = 0.5, duration = 1.0, joints = {{ first = -0.9 }} }}]
            [robot]
            model = {:?}
            joint.first.mode = \"kinematic\"
            posture = {{ first = 0.7 }}\n",
            file.path()
        ));
        assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-13), "{:?}", metrics.max_loop_error_m);
        let last = recording.snapshots.last().expect("a snapshot");
        // The joints of the file are sorted as its links: `second` is the first of them.
        let (q1, q2) = (last.q[1], last.q[0]);
        assert!((q1 + 0.9).abs() < 1e-12 && (q2 - (K * q1 + C)).abs() < 1e-12, "{q1} {q2}");
        // At rest the drive carries m1 g l1 sin q1 + K m2 g l2 sin q2.
        let ((m1, l1, _), (m2, l2, _)) = (FIRST, SECOND);
        let load = m1 * G * l1 * q1.sin() + K * m2 * G * l2 * q2.sin();
        assert!((last.effort[1] - load).abs() < 1e-9, "{} {load}", last.effort[1]);
    }
}

/// The drive's force F = kp (target - position) becomes F / 2 on each pad; friction lifts the box while
/// `mu F > m (g + a)`, and slides along it otherwise.
#[test]
fn a_gripper_with_one_drive_lifts_a_box_up_to_the_friction_of_both_fingers() {
    let scenario = |mass: f64| {
        format!(
            "duration = 1.5
            floor = {{ plane = false, friction = 0.5 }}
            integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
            contact = {{ distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }}
            log.rate = 100
            terrain = [{{ type = \"box\", name = \"pedestal\", size = [0.03, 0.03, 0.4], position = [0, 0, 0.2] }}]
            object = [{{ type = \"box\", name = \"box\", size = [0.04, 0.04, 0.04], mass = {mass}, position = [0, 0, 0.42] }}]
            [[task]]
            type = \"posture\"
            duration = 0.05
            joints = {{ left = 0.035 }}
            [[task]]
            type = \"posture\"
            start = 0.1
            duration = 1.0
            joints = {{ lift = 0.05 }}
            [robot]
            model = \"robots/gripper/gripper.toml\"
            contact = \"bodies\"
            posture = {{ left = 0.03 }}
            joint = {{ lift = {{ mode = \"kinematic\" }} }}\n"
        )
    };
    let force = 2000.0 * 0.005;
    // mu F = 5 N; the least jerk of the lift has accelerations up to 0.29 m/s^2: 4.85 N are lifted, 5.1 N are not.
    for (mass, height) in [(0.48, 0.05), (0.52, 0.0)] {
        let (metrics, recording) = watch(&scenario(mass));
        let shift = metrics.final_object_shift_m.expect("an object");
        // Drift that projection leaves.
        assert!((shift - height).abs() < 1e-9, "{mass}: {shift}");
        assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-13), "{:?}", metrics.max_loop_error_m);
        let last = recording.snapshots.last().expect("a snapshot");
        // Half of the drive's force is transmitted.
        assert!((last.couplings[0].0 - 0.5 * force).abs() < 1e-8, "{:?}", last.couplings);
        let fingers = last.links.iter().filter(|(name, _)| name.contains("finger"));
        let pressed: f64 = fingers.flat_map(|(_, link)| &link.forces).map(|f| f.y.abs()).sum();
        assert!((pressed - force).abs() < 1e-8, "{pressed}");
    }
}
