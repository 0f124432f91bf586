//! Compares the reader of MJCF with MuJoCo 4.0: masses, inertias, joints, gains, and mass matrix and
//! bias in random states. Values are written by `make_mjcf.py`.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;
use stiction::dynamics::{self, State, Workspace};
use stiction::robot::{Base, JointKind, LoopKind, Model, load};

/// Rounding of both sides.
const BOUND: f64 = 1e-9;
/// MuJoCo stores principal moments and axes, which its iteration finds to about 1e-7 of the tensor.
const TENSOR_BOUND: f64 = 1e-7;

#[derive(Deserialize)]
struct Oracle {
    floating: bool,
    gravity: [f64; 3],
    links: Vec<Link>,
    joints: Vec<Joint>,
    loops: Vec<Loop>,
    couplings: Vec<Follower>,
    configurations: Vec<Configuration>,
}

#[derive(Deserialize)]
struct Loop {
    name: Option<String>,
    weld: bool,
    bodies: [String; 2],
    points: [[f64; 3]; 2],
    quaternion: Option<[f64; 4]>,
}

#[derive(Deserialize)]
struct Follower {
    joint: String,
    leader: String,
    at: Vec<f64>,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Link {
    name: String,
    mass: f64,
    com: [f64; 3],
    inertia: [[f64; 3]; 3],
}

#[derive(Deserialize)]
struct Joint {
    name: String,
    kind: String,
    axis: [f64; 3],
    anchor: [f64; 3],
    range: Option<[f64; 2]>,
    armature: f64,
    damping: f64,
    friction: f64,
    kp: f64,
    kd: f64,
}

#[derive(Deserialize)]
struct Configuration {
    position: [f64; 3],
    quaternion: [f64; 4],
    joints: Vec<String>,
    q: Vec<f64>,
    v: Vec<f64>,
    mass: Vec<Vec<f64>>,
    bias: Option<Vec<f64>>,
}

#[track_caller]
fn assert_agrees(what: &str, got: &[f64], truth: &[f64]) {
    assert_within(BOUND, what, got, truth);
}

/// Asserts agreement relative to the greatest entry of the true values.
#[track_caller]
fn assert_within(bound: f64, what: &str, got: &[f64], truth: &[f64]) {
    assert_eq!(got.len(), truth.len(), "{what}");
    let scale = truth.iter().fold(1e-6, |a: f64, b| a.max(b.abs()));
    for (i, (g, t)) in got.iter().zip(truth).enumerate() {
        assert!((g - t).abs() <= bound * scale, "{what}[{i}]: {g} against {t}");
    }
}

fn read(name: &str) -> (Model, Oracle) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let robot = load(&folder.join("robot/mjcf").join(format!("{name}.xml")));
    let model = robot.unwrap_or_else(|e| panic!("{}", e.render(false))).model;
    let text = std::fs::read_to_string(folder.join("oracles").join(format!("mjcf_{name}.json"))).unwrap();
    (model, serde_json::from_str(&text).unwrap())
}

fn check(name: &str) {
    let (model, oracle) = read(name);
    assert_eq!(model.base == Base::Floating, oracle.floating);
    links(&model, &oracle);
    joints(&model, &oracle);
    loops(&model, &oracle);
    for truth in &oracle.configurations {
        dynamics_agree(&model, &Vector3::from(oracle.gravity), truth);
    }
}

fn links(model: &Model, oracle: &Oracle) {
    let total: f64 = oracle.links.iter().map(|link| link.mass).sum();
    assert_agrees("total mass", &[model.mass()], &[total]);
    for truth in &oracle.links {
        let link = model.links.iter().find(|link| link.name == truth.name);
        let link = link.unwrap_or_else(|| panic!("no link `{}`", truth.name));
        let body = link.body().transformed(&link.urdf_frame.inverse());
        let what = |quantity| format!("{quantity} of {}", truth.name);
        assert_agrees(&what("mass"), &[body.mass], &[truth.mass]);
        assert_agrees(&what("com"), body.com.as_slice(), &truth.com);
        let inertia = Matrix3::from_fn(|i, j| truth.inertia[i][j]);
        assert_within(TENSOR_BOUND, &what("inertia"), body.tensor.as_slice(), inertia.as_slice());
    }
}

fn joints(model: &Model, oracle: &Oracle) {
    for truth in oracle.joints.iter().filter(|joint| joint.kind != "ball") {
        let index = model.joint(&truth.name).unwrap_or_else(|| panic!("no joint `{}`", truth.name)).0;
        let (joint, link) = (&model.joints[index], &model.links[index + 1]);
        let frame = link.urdf_frame.inverse();
        let what = |quantity| format!("{quantity} of {}", truth.name);
        assert_agrees(&what("axis"), (frame.rotation * Vector3::z()).as_slice(), &truth.axis);
        assert_agrees(&what("anchor"), frame.translation.vector.as_slice(), &truth.anchor);
        assert_eq!(joint.kind == JointKind::Prismatic, truth.kind == "slide");
        let [lower, upper] = truth.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        if truth.range.is_some() {
            assert_agrees(&what("range"), &[joint.lower, joint.upper], &[lower, upper]);
        } else {
            assert_eq!((joint.lower, joint.upper), (lower, upper), "{}", truth.name);
        }
        let numbers = [joint.armature, joint.damping, joint.friction];
        assert_agrees(&what("armature, damping, friction"), &numbers, &[truth.armature, truth.damping, truth.friction]);
        assert_agrees(&what("kp, kd"), &[joint.drive.kp, joint.drive.kd], &[truth.kp, truth.kd]);
    }
}

fn loops(model: &Model, oracle: &Oracle) {
    assert_eq!(model.loops.len(), oracle.loops.len());
    for (ours, truth) in model.loops.iter().zip(&oracle.loops) {
        assert!(truth.name.as_ref().is_none_or(|name| *name == ours.name));
        assert_eq!(ours.kind == LoopKind::Weld, truth.weld, "{}", ours.name);
        let ends = [(Some(ours.link), ours.pose), (ours.other, ours.other_pose)];
        let mut turns = Vec::new();
        for (((link, pose), body), point) in ends.iter().zip(&truth.bodies).zip(&truth.points) {
            let Some(link) = link.filter(|_| body != "world") else { continue };
            let (carrier, frame) = model.link(body).unwrap();
            assert_eq!(link, carrier, "{}", ours.name);
            let in_body = frame.inverse() * pose;
            assert_agrees(&format!("{} on {body}", ours.name), in_body.translation.vector.as_slice(), point);
            turns.push(in_body.rotation);
        }
        if let (Some([w, x, y, z]), [first, second]) = (truth.quaternion, &turns[..]) {
            let relative = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            assert!((first * second.inverse()).angle_to(&relative) < 1e-7, "{}", ours.name);
        }
    }
    assert_eq!(model.couplings.len(), oracle.couplings.len());
    for (ours, truth) in model.couplings.iter().zip(&oracle.couplings) {
        assert_eq!(model.joints[ours.joint.0].name, truth.joint);
        assert_eq!(model.joints[ours.leader.0].name, truth.leader);
        let got: Vec<f64> = truth.at.iter().map(|&x| ours.evaluate(x).0).collect();
        assert_agrees("coupling", &got, &truth.values);
    }
}

fn dynamics_agree(model: &Model, gravity: &Vector3<f64>, truth: &Configuration) {
    let nb = model.nb();
    assert_eq!(truth.joints.len(), model.nj());
    let index: Vec<usize> = truth.joints.iter().map(|name| model.joint(name).expect("a joint").0).collect();
    let ours: Vec<usize> = (0..nb).chain(index.iter().map(|j| nb + j)).collect();
    let mut state = State::home(model);
    let [w, x, y, z] = truth.quaternion;
    state.position = Vector3::from(truth.position);
    state.rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    for (&j, &q) in index.iter().zip(&truth.q) {
        state.joints[j] = q;
    }
    for (&at, &v) in ours.iter().zip(&truth.v) {
        state.v[at] = v;
    }
    let mut ws = Workspace::new(model);
    dynamics::prepare(model, &state, gravity, &mut ws).unwrap();
    let mass: Vec<f64> = ours
        .iter()
        .flat_map(|&i| ours.iter().map(move |&j| (i.max(j), i.min(j))))
        .map(|(i, j)| ws.mass.get(i, j))
        .collect();
    assert_agrees("M", &mass, &truth.mass.concat());
    if let Some(bias) = &truth.bias {
        let got: Vec<f64> = ours.iter().map(|&i| ws.bias[i]).collect();
        assert_agrees("h", &got, bias);
    }
}

#[test]
fn a_floating_robot_with_meshes_and_scaled_masses_agrees() {
    check("biped");
}

#[test]
fn a_fixed_arm_with_classes_references_and_servos_agrees() {
    check("arm");
}

#[test]
fn balls_meshes_by_each_rule_and_shells_agree() {
    check("shapes");
}

/// Names and poses of copies, and of what names them; the sensor is one for each copy.
#[test]
fn replicated_elements_agree() {
    check("replicate");
    let (model, _) = read("replicate");
    let names: Vec<&str> = model.sensors.imu.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!(names, ["tip-0", "tip-1", "tip-2"]);
}

/// An attached model keeps its own classes, meshes, drives and constraints, also where it is copied.
#[test]
fn attached_models_agree() {
    check("attach");
}
