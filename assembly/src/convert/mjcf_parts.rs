//! Parts of MJCF next to the bodies: sites, sensors, actuators, constraints, the home posture.

use nalgebra::{Isometry3, Point3, Vector3};

use super::xml_text::{Lines, escape, number, numbers, wxyz};
use crate::robot::{Base, DriveMode, LoopKind, Model};

/// Distance of the two points that hold the axis of a pin, m.
const PIN: f64 = 0.1;
/// Stands for an effort limit of 0, N m or N, which MJCF lacks; mjMINVAL of MuJoCo.
pub(super) const NO_EFFORT: f64 = 1e-15;

/// Sites on a link: vertices of soles, sensors, end effectors, ends of loops. `to_body` leads from
/// the internal frame to the body's.
pub(super) fn sites(model: &Model, link: usize, to_body: &Isometry3<f64>, lines: &mut Lines) {
    let mut site = |name: &str, pose: &Isometry3<f64>| {
        let pose = to_body * pose;
        let (pos, quat) = (numbers(pose.translation.vector.as_slice()), wxyz(&pose.rotation));
        let name = escape(name);
        lines.line(&format!("<site name=\"{name}\" pos=\"{pos}\" quat=\"{quat}\" size=\"0.004\" group=\"4\"/>"));
    };
    for sole in model.soles.iter().filter(|s| s.link.0 == link) {
        for (k, vertex) in sole.vertices.iter().enumerate() {
            site(&format!("sole/{}/{k}", sole.name), &Isometry3::translation(vertex.x, vertex.y, vertex.z));
        }
    }
    for (kind, sensor) in sensor_frames(model).filter(|(_, s)| s.mount.link.0 == link) {
        site(&format!("{kind}/{}", sensor.name), &sensor.mount.pose);
    }
    for effector in model.end_effectors.iter().filter(|e| e.link.0 == link) {
        site(&format!("end_effector/{}", effector.name), &effector.pose);
    }
    for closure in &model.loops {
        let ends = [(Some(closure.link), &closure.pose, 0), (closure.other, &closure.other_pose, 1)];
        for (_, pose, end) in ends.into_iter().filter(|(on, ..)| on.is_some_and(|on| on.0 == link)) {
            site(&format!("loop/{}/{end}", closure.name), pose);
            if closure.kind == LoopKind::Pin {
                let along = pose * Isometry3::translation(0.0, 0.0, PIN);
                site(&format!("loop/{}/axis/{end}", closure.name), &along);
            }
        }
    }
}

fn sensor_frames(model: &Model) -> impl Iterator<Item = (&'static str, &crate::robot::SensorFrame)> {
    let imus = model.sensors.imu.iter().map(|sensor| ("imu", sensor));
    imus.chain(model.sensors.force.iter().map(|sensor| ("force", sensor)))
}

/// Couplings as polynomials, loops as connections of sites; a loop at the world, and a rod, are
/// reported.
pub(super) fn equalities(model: &Model, lines: &mut Lines, warnings: &mut Vec<String>) {
    let mut inner: Vec<String> = Vec::new();
    for coupling in &model.couplings {
        let [joint, leader] = [coupling.joint, coupling.leader].map(|id| escape(&model.joints[id.0].name));
        let coefficients = numbers(&coupling.coefficients);
        // A joint that is held has no other one.
        let second = if leader == joint { String::new() } else { format!(" joint2=\"{leader}\"") };
        inner.push(format!("<joint joint1=\"{joint}\"{second} polycoef=\"{coefficients}\"/>"));
    }
    for closure in &model.loops {
        let name = escape(&closure.name);
        let ends = |part: &str| format!("site1=\"loop/{name}{part}/0\" site2=\"loop/{name}{part}/1\"");
        // The second connection of a pin has no name: both are read as one loop.
        let connect = |part: &str| format!("<connect {}/>", ends(part));
        let named = format!("<connect name=\"{name}\" {}/>", ends(""));
        match (closure.kind, closure.other) {
            (LoopKind::Rod(_), _) => warnings.push(format!("the rod `{}` is not written", closure.name)),
            (_, None) => warnings.push(format!("the loop `{}`, which the world closes, is not written", closure.name)),
            (LoopKind::Ball, _) => inner.push(named),
            (LoopKind::Pin, _) => inner.extend([named, connect("/axis")]),
            (LoopKind::Weld, _) => inner.push(format!("<weld name=\"{name}\" {}/>", ends(""))),
        }
    }
    section("equality", &inner, lines);
}

/// The drives of joints.
pub(super) fn actuators(model: &Model, lines: &mut Lines) {
    let mut inner = Vec::new();
    for joint in &model.joints {
        let (name, kp, kd) = (escape(&joint.name), number(joint.drive.kp), number(joint.drive.kd));
        let head = match joint.drive.mode {
            DriveMode::Position => format!("<position name=\"{name}\" joint=\"{name}\" kp=\"{kp}\" kv=\"{kd}\""),
            DriveMode::Velocity => format!("<velocity name=\"{name}\" joint=\"{name}\" kv=\"{kd}\""),
            DriveMode::Force => format!("<motor name=\"{name}\" joint=\"{name}\""),
            DriveMode::Passive | DriveMode::Kinematic => continue,
        };
        let limit = joint.effort_limit;
        let range = match limit.is_finite() {
            true => format!(" forcerange=\"{}\"", numbers(&[-limit.max(NO_EFFORT), limit.max(NO_EFFORT)])),
            false => String::new(),
        };
        inner.push(format!("{head}{range}/>"));
    }
    section("actuator", &inner, lines);
}

/// Rates, accelerations and orientation of inertial sensors; forces and moments of the others.
pub(super) fn sensors(model: &Model, lines: &mut Lines) {
    let mut inner = Vec::new();
    for (kind, sensor) in sensor_frames(model) {
        let site = escape(&format!("{kind}/{}", sensor.name));
        let tags: &[&str] = if kind == "imu" { &["gyro", "accelerometer"] } else { &["force", "torque"] };
        for tag in tags {
            inner.push(format!("<{tag} name=\"{site}/{tag}\" site=\"{site}\"/>"));
        }
    }
    section("sensor", &inner, lines);
}

/// The home posture and the keyframes, the lowest sole vertex on the floor.
pub(super) fn keyframes(model: &Model, lines: &mut Lines) {
    let key = |name: &str, joints: &[f64]| {
        let mut qpos = Vec::new();
        if model.base == Base::Floating {
            qpos.extend([0.0, 0.0, 0.0 - lowest_vertex(model, joints), 1.0, 0.0, 0.0, 0.0]);
        }
        qpos.extend(joints);
        (!qpos.is_empty()).then(|| format!("<key name=\"{}\" qpos=\"{}\"/>", escape(name), numbers(&qpos)))
    };
    let others = model.keyframes.iter().filter(|keyframe| keyframe.name != "home");
    let others = others.filter_map(|keyframe| key(&keyframe.name, &keyframe.joints));
    let keys: Vec<String> = key("home", &model.home).into_iter().chain(others).collect();
    section("keyframe", &keys, lines);
}

/// Height of the lowest vertex of a sole above the root's origin, m; 0 without soles.
fn lowest_vertex(model: &Model, joints: &[f64]) -> f64 {
    let poses = crate::robot::link_poses(model, joints);
    let vertices = model.soles.iter().flat_map(|s| s.vertices.iter().map(|v: &Vector3<f64>| (s.link.0, *v)));
    let lowest = vertices.map(|(link, v)| (poses[link] * Point3::from(v)).z).fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest } else { 0.0 }
}

fn section(tag: &str, inner: &[String], lines: &mut Lines) {
    if inner.is_empty() {
        return;
    }
    lines.open(&format!("<{tag}>"));
    inner.iter().for_each(|line| lines.line(line));
    lines.close(&format!("</{tag}>"));
}
