//! Compares the context of tasks with Pinocchio 4.1 on HOAP-2.

use super::dynamics_oracle::matrix;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use stiction::dynamics::State;
use stiction::geometry::Plane;
use stiction::robot::{EndEffector, JointId, Model};
use stiction::task::{AugmentedData, Needs, SensorReadings};

#[derive(Deserialize)]
struct Oracle {
    gravity: [f64; 3],
    names: Vec<String>,
    end_effectors: Vec<Effector>,
    configurations: Vec<Configuration>,
}

#[derive(Deserialize)]
struct Effector {
    name: String,
    link: String,
    position: [f64; 3],
    rpy: [f64; 3],
}

#[derive(Deserialize)]
struct Configuration {
    position: [f64; 3],
    rotation: [[f64; 3]; 3],
    joints: Vec<f64>,
    v: Vec<f64>,
    floor: [[f64; 3]; 3],
    origin: [f64; 3],
    com: [f64; 3],
    com_velocity: [f64; 3],
    com_jacobian: Vec<Vec<f64>>,
    com_jacobian_base: Vec<Vec<f64>>,
    gravity_effort: Vec<f64>,
    bias: Vec<f64>,
    frames: Vec<Frame>,
    vertices: Vec<[f64; 3]>,
    vertex_jacobians: Vec<Vec<Vec<f64>>>,
    vertex_forces: Vec<[f64; 3]>,
    zmp: [f64; 3],
}

#[derive(Deserialize)]
struct Frame {
    position: [f64; 3],
    rotation: [[f64; 3]; 3],
    jacobian: Vec<Vec<f64>>,
    twist: [f64; 6],
}

/// Rounding of both sides: a few hundred operations on numbers of the size of the greatest entry.
const BOUND: f64 = 1e-10;

#[track_caller]
fn assert_agrees(what: &str, got: &[f64], truth: &[f64]) {
    assert_eq!(got.len(), truth.len(), "{what}");
    let scale = truth.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (i, (g, t)) in got.iter().zip(truth).enumerate() {
        // This form of the comparison also fails for NaN.
        assert!((g - t).abs() <= BOUND * scale, "{what}[{i}]: {g} against {t}");
    }
}

/// Our joint for each of the oracle's.
struct Order(Vec<usize>);

impl Order {
    fn joints(&self, theirs: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; theirs.len()];
        self.0.iter().zip(theirs).for_each(|(&j, x)| out[j] = *x);
        out
    }

    fn velocities(&self, theirs: &[f64]) -> Vec<f64> {
        [&theirs[..6], &self.joints(&theirs[6..])].concat()
    }

    /// Compares rows in the oracle's order of columns with columns in ours.
    #[track_caller]
    fn jacobian(&self, what: &str, got: &[f64], rows: &[Vec<f64>], joints_only: bool) {
        let rows: Vec<Vec<f64>> =
            rows.iter().map(|r| if joints_only { self.joints(r) } else { self.velocities(r) }).collect();
        let truth: Vec<f64> = (0..rows[0].len()).flat_map(|k| rows.iter().map(move |r| r[k])).collect();
        assert_agrees(what, got, &truth);
    }
}

fn robot(oracle: &Oracle) -> Model {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    let mut model = stiction::robot::load(&path).expect("our own robot").model;
    model.end_effectors = oracle
        .end_effectors
        .iter()
        .map(|e| {
            let (link, frame) = model.link(&e.link).expect("a link of that name");
            let turn = UnitQuaternion::from_euler_angles(e.rpy[0], e.rpy[1], e.rpy[2]);
            let pose = frame * Isometry3::from_parts(Translation3::from(e.position), turn);
            EndEffector { name: e.name.clone(), link, pose }
        })
        .collect();
    model
}

fn state(model: &Model, order: &Order, truth: &Configuration) -> State {
    let mut state = State::home(model);
    state.position = truth.position.into();
    let turn = Rotation3::from_matrix_unchecked(matrix(&truth.rotation));
    state.rotation = UnitQuaternion::from_rotation_matrix(&turn);
    state.joints = order.joints(&truth.joints);
    state.v = order.velocities(&truth.v);
    state
}

/// Readings of force sensors in both feet.
fn sensed(model: &Model, truth: &Configuration) -> SensorReadings {
    let mut sensed = SensorReadings::blank(model);
    for (s, load) in sensed.soles.iter_mut().enumerate() {
        let points: Vec<Vector3<f64>> = truth.vertices[4 * s..4 * s + 4].iter().map(|p| Vector3::from(*p)).collect();
        let centre = points.iter().sum::<Vector3<f64>>() / 4.0;
        for (i, p) in points.iter().enumerate() {
            let force = Vector3::from(truth.vertex_forces[4 * s + i]);
            load.force += force;
            load.moment += (p - centre).cross(&force);
        }
    }
    sensed
}

#[test]
fn the_context_of_tasks_agrees_with_pinocchio() {
    let oracle: Oracle = serde_json::from_str(include_str!("context_hoap2.json")).expect("a file of make_context.py");
    let model = robot(&oracle);
    let order = Order(oracle.names.iter().map(|n| model.joint(n).map(|JointId(j)| j).expect("a joint")).collect());
    assert!(oracle.configurations.len() >= 3 && model.soles.len() == 2 && model.end_effectors.len() == 5);
    let mut data = AugmentedData::new(&model);
    for truth in &oracle.configurations {
        let state = state(&model, &order, truth);
        let floor = Plane { rotation: matrix(&truth.floor), point: truth.origin.into() };
        let sensed = sensed(&model, truth);
        data.update(&model, &state, &sensed, &oracle.gravity.into(), &floor, Needs::ALL);

        assert_agrees("com", data.com.as_slice(), &truth.com);
        assert_agrees("com velocity", data.com_velocity.as_slice(), &truth.com_velocity);
        order.jacobian("com jacobian", &data.com_jacobian, &truth.com_jacobian, false);
        order.jacobian("com jacobian, base", &data.com_jacobian_base, &truth.com_jacobian_base, true);
        assert_agrees("gravity", &data.gravity_effort, &order.velocities(&truth.gravity_effort));
        assert_agrees("bias", &data.workspace.bias, &order.velocities(&truth.bias));
        for ((got, frame), effector) in data.end_effectors.iter().zip(&truth.frames).zip(&oracle.end_effectors) {
            let name = &effector.name;
            assert_agrees(name, got.pose.translation.vector.as_slice(), &frame.position);
            let turn = got.pose.rotation.to_rotation_matrix();
            assert_agrees(name, turn.matrix().as_slice(), matrix(&frame.rotation).as_slice());
            order.jacobian(name, &got.jacobian, &frame.jacobian, false);
            let twist: Vec<f64> = got.twist.linear.iter().chain(&got.twist.angular).copied().collect();
            assert_agrees(name, &twist, &frame.twist);
        }
        for (s, sole) in data.soles.iter().enumerate() {
            // The oracle's foot frames are at the mean of the vertices.
            order.jacobian("sole", &sole.jacobian, &truth.frames[s].jacobian, false);
            assert_agrees("sole", sole.position.as_slice(), &truth.frames[s].position);
            for (i, jacobian) in sole.vertex_jacobians.iter().enumerate() {
                assert_agrees("vertex", sole.vertices[i].as_slice(), &truth.vertices[4 * s + i]);
                order.jacobian("vertex", jacobian, &truth.vertex_jacobians[4 * s + i], false);
            }
        }
        assert_agrees("zmp", data.zmp.expect("the floor presses").as_slice(), &truth.zmp);
    }
}
