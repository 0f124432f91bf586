//! Each term of an observation against the state from which it follows, to the bit of single precision.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use stiction::dynamics::State;
use stiction::task::{Command, SensorReadings};

use super::folder;
use super::onnx_file::{affine, identity};
use super::support::{hoap2, setup, ticks};

/// Joints of HOAP-2, as many as an observation has numbers.
const JOINTS: [&str; 12] = [
    "left_hip_yaw",
    "left_hip_roll",
    "left_hip_pitch",
    "left_knee",
    "left_ankle_pitch",
    "left_ankle_roll",
    "right_hip_yaw",
    "right_hip_roll",
    "right_hip_pitch",
    "right_knee",
    "right_ankle_pitch",
    "right_ankle_roll",
];

/// A task whose network returns the observation: the commands are its numbers.
fn echo(width: usize, observations: &str, more: &str) -> String {
    let joints = &JOINTS[..width];
    let home: Vec<String> = joints.iter().map(|joint| format!("{joint} = 0")).collect();
    let home = home.join(", ");
    hoap2(&format!(
        "posture = {{ {home} }}\nobservations = [{observations}]\naction = {{ joints = {joints:?} }}\n{more}"
    ))
}

/// A state without any zero: the base tilted and moving, the feet loaded.
fn state(state: &mut State, sensed: &mut SensorReadings) {
    state.position = Vector3::new(0.11, -0.23, 0.37);
    state.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.5, 2.9));
    for (i, v) in state.v.iter_mut().enumerate() {
        *v = 0.1 * (i as f64 + 1.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
    }
    for (i, q) in state.joints.iter_mut().enumerate() {
        *q = 0.01 * (i as f64 - 7.3);
    }
    for (i, sole) in sensed.soles.iter_mut().enumerate() {
        sole.force = Vector3::new(1.5, -2.5, [30.0, 0.9][i]);
    }
}

/// The numbers of one observation.
fn observed(width: usize, observation: &str, more: &str) -> (Vec<f64>, State, SensorReadings, Command) {
    let folder = folder(identity(width));
    let mut setup = setup(&folder, &echo(width, observation, more));
    let (mut at, mut readings) = (State::home(&setup.model), SensorReadings::blank(&setup.model));
    state(&mut at, &mut readings);
    let command = ticks(&mut setup, 1, state).remove(0);
    let index = |name: &str| setup.model.joint(name).expect("a joint").0;
    (JOINTS[..width].iter().map(|name| command.position[index(name)]).collect(), at, readings, command)
}

/// Numbers in single precision; the only rounding after that of the closed form.
#[track_caller]
fn assert_observed(found: &[f64], expected: &[f64]) {
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        // The closed form is computed by matrices instead of quaternions: a few roundings of double precision.
        assert!((found - expected).abs() < 6e-8 * expected.abs() + 1e-15, "number {i}: {found} instead of {expected}");
    }
    assert_eq!(found.len(), expected.len());
}

#[test]
fn the_motion_of_the_base_is_in_its_axes() {
    let turned = |v: Vector3<f64>, at: &State| {
        let rotation: Rotation3<f64> = at.rotation.to_rotation_matrix();
        (rotation.matrix().transpose() * v).as_slice().to_vec()
    };
    let (found, at, ..) = observed(3, "{ term = \"linear-velocity\" }", "");
    assert_observed(&found, &turned(Vector3::new(0.1, -0.2, 0.3), &at));
    let (found, at, ..) = observed(3, "{ term = \"angular-velocity\" }", "");
    assert_observed(&found, &turned(Vector3::new(-0.4, 0.5, -0.6), &at));
    let (found, at, ..) = observed(3, "{ term = \"gravity\" }", "[floor]\nrpy = [0.2, 0.1, 0]");
    assert_observed(&found, &turned(Vector3::new(0.0, 0.0, -1.0), &at));
    let (found, at, ..) = observed(4, "{ term = \"orientation\" }", "");
    let q = at.rotation.quaternion();
    let sign = q.w.signum();
    assert_observed(&found, &[sign * q.w, sign * q.i, sign * q.j, sign * q.k]);
    assert!(found[0] > 0.0);
    let (found, ..) = observed(1, "{ term = \"height\" }", "[floor]\nheight = 0.1");
    assert_observed(&found, &[0.27]);
}

/// A rotation by almost a whole turn has a quaternion whose first number is negative.
#[test]
fn the_quaternion_has_a_positive_first_number() {
    let folder = folder(identity(4));
    let mut setup = setup(&folder, &echo(4, "{ term = \"orientation\" }", ""));
    let turned = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(-0.5, 0.5, -0.5, 0.5));
    let command = ticks(&mut setup, 1, |state, _| state.rotation = turned).remove(0);
    let index = |name: &str| setup.model.joint(name).expect("a joint").0;
    assert_observed(
        &JOINTS[..4].iter().map(|j| command.position[index(j)]).collect::<Vec<_>>(),
        &[0.5, -0.5, 0.5, -0.5],
    );
}

#[test]
fn joints_are_named_listed_or_matched() {
    let joints = "joints = [\"right_knee\", \"left_*_pitch\"]";
    let (found, at, _, _) = observed(4, &format!("{{ term = \"joint-velocities\", {joints} }}"), "");
    let model = stiction::robot::load(std::path::Path::new("robots/hoap2/hoap2.toml")).expect("our own robot").model;
    let index = |name: &str| model.joint(name).expect("a joint").0;
    let mut pitch: Vec<usize> = ["left_hip_pitch", "left_ankle_pitch", "left_shoulder_pitch"].map(index).to_vec();
    pitch.sort_unstable();
    let order = [vec![index("right_knee")], pitch].concat();
    assert_observed(&found, &order.iter().map(|j| at.rates()[*j]).collect::<Vec<_>>());
}

#[test]
fn joint_positions_are_relative_to_the_default_posture() {
    // Joints of the action by default; their default posture is 0, that of others the home posture.
    let (found, at, _, _) = observed(12, "{ term = \"joint-positions\" }", "");
    let model = stiction::robot::load(std::path::Path::new("robots/hoap2/hoap2.toml")).expect("our own robot").model;
    let q = |name: &str| at.joints[model.joint(name).expect("a joint").0];
    assert_observed(&found, &JOINTS.map(q));
    let shoulder = "joints = [\"left_shoulder_pitch\"]";
    let (found, ..) = observed(1, &format!("{{ term = \"joint-positions\", {shoulder} }}"), "");
    assert_observed(&found, &[q("left_shoulder_pitch") - std::f64::consts::FRAC_PI_2]);
    let (found, ..) = observed(1, &format!("{{ term = \"joint-positions\", {shoulder}, relative = false }}"), "");
    assert_observed(&found, &[q("left_shoulder_pitch")]);
}

#[test]
fn loads_of_soles_are_forces_and_flags() {
    let (found, at, sensed, _) = observed(6, "{ term = \"sole-forces\" }", "");
    let rotation = at.rotation.to_rotation_matrix();
    let expected: Vec<f64> =
        sensed.soles.iter().flat_map(|s| (rotation.matrix().transpose() * s.force).as_slice().to_vec()).collect();
    assert_observed(&found, &expected);
    // 0.9 N is less than the default of 1 N; on a tilted floor the normal force counts.
    assert_eq!(observed(2, "{ term = \"contacts\" }", "").0, [1.0, 0.0]);
    assert_eq!(observed(2, "{ term = \"contacts\", threshold = 0.8 }", "").0, [1.0, 1.0]);
    assert_eq!(observed(2, "{ term = \"contacts\", threshold = 30 }", "").0, [1.0, 0.0]);
    assert_eq!(observed(2, "{ term = \"contacts\", threshold = 30 }", "[floor]\nrpy = [0.3, 0, 0]").0, [0.0, 0.0]);
    assert_eq!(observed(1, "{ term = \"contacts\", soles = [\"right\"] }", "").0, [0.0]);
}

#[test]
fn scale_offset_and_clip_apply_in_this_order() {
    let command = |more: &str| observed(3, &format!("{{ term = \"command\", values = [1, -2, 4]{more} }}"), "").0;
    assert_eq!(command(""), [1.0, -2.0, 4.0]);
    assert_eq!(command(", scale = 0.5"), [0.5, -1.0, 2.0]);
    assert_eq!(command(", scale = [2, 3, 0.25], offset = 1"), [3.0, -5.0, 2.0]);
    assert_eq!(command(", scale = 2, offset = [0, 0, 1], clip = 3"), [2.0, -3.0, 3.0]);
    // Rounded once, to the nearest number of single precision.
    assert_eq!(command(", scale = 0.1"), [0.1_f32, -0.2_f32, 0.4_f32].map(f64::from));
}

/// Phases in ticks of a control rate of 1 kHz.
#[test]
fn sine_and_cosine_follow_the_time_from_the_start() {
    let folder = folder(identity(2));
    let terms = "{ term = \"sine\", period = 0.008 }, { term = \"cosine\", period = 0.016, phase = \"90 deg\" }";
    let mut setup = setup(&folder, &echo(2, terms, "start = 0.25"));
    let index = |name: &str| setup.model.joint(name).expect("a joint").0;
    let joints = [index(JOINTS[0]), index(JOINTS[1])];
    for (k, command) in ticks(&mut setup, 20, |_, _| {}).into_iter().enumerate() {
        let angle = std::f64::consts::TAU * k as f64 / 8.0;
        // Rounding of the time of a tick, which the period divides, and of the result.
        assert!((command.position[joints[0]] - angle.sin()).abs() < 1e-7, "{k}");
        assert!((command.position[joints[1]] + (0.5 * angle).sin()).abs() < 1e-7, "{k}");
    }
}

/// The network sums its two inputs with the weights 1 and 10.
#[test]
fn observations_of_a_history_have_their_order() {
    let sums = |more: &str| {
        let folder = folder(affine(4, &[1.0, 10.0, 100.0, 1000.0], &[0.0]));
        let terms = "{ term = \"joint-positions\", joints = [\"head_pan\"] }, { term = \"height\" }";
        let mut setup = setup(&folder, &echo(1, terms, &format!("history = 2\n{more}")));
        let (head, out) = (setup.model.joint("head_pan").expect("a joint").0, setup.model.joint(JOINTS[0]).unwrap().0);
        let mut k = 0.0;
        let commands = ticks(&mut setup, 3, |state, _| {
            k += 1.0;
            (state.joints[head], state.position.z) = (k, k + 4.0);
        });
        commands.into_iter().map(|command| command.position[out]).collect::<Vec<_>>()
    };
    // At tick k the two terms are k and k + 4; at the first tick both observations are the first one.
    assert_eq!(sums(""), [5151.0, 6251.0, 7362.0]);
    assert_eq!(sums("newest_first = true"), [5151.0, 5162.0, 6273.0]);
    assert_eq!(sums("by_term = true"), [5511.0, 6521.0, 7632.0]);
    assert_eq!(sums("by_term = true\nnewest_first = true"), [5511.0, 5612.0, 6723.0]);
}
