//! Actions of networks: gains, limits, memory and time, against closed forms and a script.

use stiction::robot::DriveMode;

use super::folder;
use super::onnx_file::{FLOAT, affine, constant, file, identity, node, value};
use super::support::{hoap2, setup, ticks};
use crate::support::folder::Folder;

const COMMAND: &str = "observations = [{ term = \"command\", values = [0.5, -3.0] }]";

#[test]
fn positions_are_the_posture_plus_the_scaled_output() {
    let task = "posture = { left_knee = 0.25, right_knee = 1.0 }
        action = { joints = [\"right_knee\", \"left_knee\"], scale = [0.5, 0.25], clip = 2, kp = [10, 20], kd = 3 }";
    let mut setup = setup(&folder(identity(2)), &hoap2(&format!("{COMMAND}\n{task}")));
    let command = ticks(&mut setup, 1, |_, _| {}).remove(0);
    let [right, left] = ["right_knee", "left_knee"].map(|name| setup.model.joint(name).expect("a joint").0);
    assert_eq!((command.position[right], command.position[left]), (1.25, -0.25));
    assert_eq!((command.velocity[right], command.mode[right]), (0.0, DriveMode::Position));
    assert_eq!((command.kp[right], command.kp[left], command.kd[right], command.kd[left]), (10.0, 20.0, 3.0, 3.0));
    // Other joints keep their commands.
    let hip = setup.model.joint("left_hip_pitch").expect("a joint").0;
    assert_eq!((command.position[hip], command.kp[hip]), (setup.model.home[hip], 150.0));
}

#[test]
fn efforts_are_the_scaled_output_while_the_task_lasts() {
    let task = "duration = 0.002\naction = { joints = [\"right_knee\", \"left_knee\"], mode = \"force\", scale = 4 }";
    let mut setup = setup(&folder(identity(2)), &hoap2(&format!("{COMMAND}\n{task}")));
    let commands = ticks(&mut setup, 3, |_, _| {});
    let [right, left] = ["right_knee", "left_knee"].map(|name| setup.model.joint(name).expect("a joint").0);
    for command in &commands[..2] {
        assert_eq!((command.effort[right], command.effort[left]), (2.0, -12.0));
        assert_eq!((command.mode[right], command.position[right]), (DriveMode::Force, setup.model.home[right]));
    }
    assert_eq!(commands[2].mode[right], DriveMode::Position, "the mode ends with the task");
}

#[test]
fn later_tasks_override_a_policy() {
    let task = "action = { joints = [\"right_knee\", \"left_knee\"] }
        [[task]]\ntype = \"posture\"\nduration = 0.001\njoints = { left_knee = 0.75 }";
    let mut setup = setup(&folder(identity(2)), &hoap2(&format!("{COMMAND}\n{task}")));
    let command = ticks(&mut setup, 2, |_, _| {}).remove(1);
    let [right, left] = ["right_knee", "left_knee"].map(|name| setup.model.joint(name).expect("a joint").0);
    assert_eq!(command.position[left], 0.75);
    assert!((command.position[right] - (setup.model.home[right] + 0.5)).abs() < 1e-15);
}

#[test]
fn the_action_is_held_between_evaluations() {
    let task = "decimation = 4\nposture = { left_knee = 0 }
        observations = [{ term = \"height\" }]\naction = { joints = [\"left_knee\"] }";
    let mut setup = setup(&folder(identity(1)), &hoap2(task));
    let knee = setup.model.joint("left_knee").expect("a joint").0;
    let mut k = 0.0;
    let commands = ticks(&mut setup, 10, |state, _| {
        state.position.z = k;
        k += 1.0;
    });
    let found: Vec<f64> = commands.iter().map(|command| command.position[knee]).collect();
    assert_eq!(found, [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0, 8.0, 8.0]);
}

#[test]
fn new_commands_apply_from_their_times_on() {
    let task = format!(
        "{COMMAND}\nposture = {{ left_knee = 0, right_knee = 0 }}\naction = {{ joints = [\"right_knee\", \"left_knee\"] }}
        change = [{{ at = 0.002, values = [0.25, 1] }}, {{ at = 0.0035, values = [2, 3] }}]"
    );
    let mut setup = setup(&folder(identity(2)), &hoap2(&task));
    let knee = setup.model.joint("right_knee").expect("a joint").0;
    let found: Vec<f64> = ticks(&mut setup, 6, |_, _| {}).iter().map(|command| command.position[knee]).collect();
    assert_eq!(found, [0.5, 0.5, 0.25, 0.25, 2.0, 2.0]);
}

/// a' = 0.5 a + 1 from a = 0: 2 - 2 / 2^k, exact in single precision; and limited to 1.75.
#[test]
fn the_previous_action_is_the_limited_output() {
    let outputs = |clip: &str| {
        let task = format!(
            "posture = {{ left_knee = 0 }}\nobservations = [{{ term = \"previous-action\" }}]
            action = {{ joints = [\"left_knee\"], scale = 8{clip} }}"
        );
        let mut setup = setup(&folder(affine(1, &[0.5], &[1.0])), &hoap2(&task));
        let knee = setup.model.joint("left_knee").expect("a joint").0;
        ticks(&mut setup, 5, |_, _| {}).iter().map(|command| command.position[knee] / 8.0).collect::<Vec<_>>()
    };
    assert_eq!(outputs(""), [1.0, 1.5, 1.75, 1.875, 1.9375]);
    assert_eq!(outputs(", clip = 1.7"), [1.0, 1.5].into_iter().chain([f64::from(1.7_f32); 3]).collect::<Vec<_>>());
}

/// h' = h + x, y = 2 h': the sum of all observations.
#[test]
fn states_are_those_of_the_evaluation_before() {
    let one = [None, Some(1)];
    let network = file(
        &[value("h_in", FLOAT, &one), value("obs", FLOAT, &one)],
        &[value("actions", FLOAT, &one), value("h_out", FLOAT, &one)],
        &[constant("two", &[1], &[2.0])],
        &[node("Add", &["h_in", "obs"], &["h_out"]), node("Mul", &["h_out", "two"], &["actions"])],
    );
    let task = "posture = { left_knee = 0 }\nstate = [{ input = \"h_in\", output = \"h_out\" }]
        observations = [{ term = \"height\" }]\naction = { joints = [\"left_knee\"] }";
    let mut setup = setup(&folder(network), &hoap2(task));
    let knee = setup.model.joint("left_knee").expect("a joint").0;
    let mut k = 0.0;
    let commands = ticks(&mut setup, 4, |state, _| {
        k += 1.0;
        state.position.z = k;
    });
    assert_eq!(commands.iter().map(|command| command.position[knee]).collect::<Vec<_>>(), [2.0, 6.0, 12.0, 20.0]);
}

/// A law of efforts, -2 q - 0.5 qd with another sum for the other joint, by a network and by a script.
#[test]
fn a_linear_law_gives_the_motion_of_a_script() {
    let robot = "duration = 2.0\ncontrol.rate = 200
        robot = { model = \"ROBOTS/pendulum/pendulum.urdf\", posture = { shoulder = 0.3, elbow = -0.2 }, joint_default = { mode = \"force\" } }";
    let network = affine(4, &[-2.0, 0.25, 0.5, -1.0, -0.5, 0.0, 0.0, -0.25], &[0.0, 0.125]);
    let script = "function run(robot)
        local q, v = robot.q, robot.qd
        robot.set_effort(1, -2 * q[1] + 0.5 * q[2] - 0.5 * v[1])
        robot.set_effort(2, 0.25 * q[1] - q[2] - 0.25 * v[2] + 0.125)
    end";
    let folder = Folder::with(&[("law.luau", script)]);
    std::fs::write(folder.path().join("n.onnx"), network).expect("the folder is writable");
    let policy = format!(
        "{robot}\n[[task]]\ntype = \"policy\"\nfile = \"n.onnx\"
        observations = [{{ term = \"joint-positions\" }}, {{ term = \"joint-velocities\" }}]
        action = {{ joints = [\"shoulder\", \"elbow\"], mode = \"force\" }}"
    );
    let scripted = format!("{robot}\n[[task]]\ntype = \"script\"\nfile = \"law.luau\"");
    let last = |text: String| folder.watch(&text).1.snapshots.last().expect("a snapshot").q.clone();
    let [by_network, by_script] = [policy, scripted].map(last);
    for (found, expected) in by_network.iter().zip(&by_script) {
        // Single precision of the observations and efforts, 6e-8, over some swings of 0.3 rad.
        assert!((found - expected).abs() < 1e-6, "{by_network:?} instead of {by_script:?}");
    }
    assert_ne!(by_network, by_script);
}
