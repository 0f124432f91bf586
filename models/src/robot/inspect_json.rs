//! JSON output of `runner inspect`: the model in the frames and units of [`super::inspect()`].

use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::{Value, json};

use super::Robot;
use super::closure::LoopKind;
use super::mass_matrix::mass_matrix;
use super::model::{Base, DriveMode, Joint, JointId, JointKind, Link, LinkId, Model, SensorFrame};
use crate::text::Severity;

/// The robot as JSON. Poses are positions and quaternions `w x y z`; `null` is an absent limit.
pub fn inspect_json(robot: &Robot) -> Value {
    let model = &robot.model;
    let link = |id: LinkId| model.links[id.0].name.as_str();
    let sensor = |SensorFrame { name, mount }: &SensorFrame| {
        let pose = on_link(model, mount.link, &mount.pose);
        json!({ "name": name, "link": link(mount.link), "pose": pose })
    };
    let joint = |id: JointId| model.joints[id.0].name.as_str();
    let matrix = mass_matrix(model, &model.home);
    let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    json!({
        "name": model.name,
        "files": robot.files.iter().map(|(path, _)| path.display().to_string()).collect::<Vec<_>>(),
        "base": if model.base == Base::Fixed { "fixed" } else { "floating" },
        "mass": model.mass(),
        "links": model.links.iter().map(|l| link_json(model, l)).collect::<Vec<_>>(),
        "joints": model.joints.iter().enumerate().map(|(i, j)| joint_json(model, i, j)).collect::<Vec<_>>(),
        "keyframes": model.keyframes.iter().map(|k| json!({ "name": k.name, "joints": k.joints })).collect::<Vec<_>>(),
        "couplings": model.couplings.iter().map(|c| json!({
            "joint": joint(c.joint), "leader": joint(c.leader), "coefficients": c.coefficients,
        })).collect::<Vec<_>>(),
        "loops": model.loops.iter().map(|l| json!({
            "name": l.name,
            "kind": loop_kind(l.kind),
            "length": if let LoopKind::Rod(length) = l.kind { Some(length) } else { None },
            "link": link(l.link),
            "pose": on_link(model, l.link, &l.pose),
            "other": l.other.map(link),
            "other_pose": l.other.map_or_else(|| pose(&l.other_pose), |other| on_link(model, other, &l.other_pose)),
        })).collect::<Vec<_>>(),
        "transmissions": model.transmissions.iter().map(|t| json!({
            "name": t.name,
            "joints": t.joints.iter().map(|id| joint(*id)).collect::<Vec<_>>(),
            "gear": t.gear.chunks(t.number()).collect::<Vec<_>>(),
            "rotor_inertia": t.rotor_inertia,
            "effort_limit": t.effort_limit,
            "velocity_limit": t.velocity_limit,
        })).collect::<Vec<_>>(),
        "soles": model.soles.iter().map(|s| {
            let back = model.links[s.link.0].urdf_frame.inverse();
            let polygon: Vec<[f64; 3]> = s.vertices.iter().map(|v| (back * Point3::from(*v)).coords.into()).collect();
            json!({ "name": s.name, "link": link(s.link), "polygon": polygon })
        }).collect::<Vec<_>>(),
        "sensors": {
            "imu": model.sensors.imu.iter().map(sensor).collect::<Vec<_>>(),
            "force": model.sensors.force.iter().map(sensor).collect::<Vec<_>>(),
        },
        "end_effectors": model.end_effectors.iter().map(|e| json!({
            "name": e.name, "link": link(e.link), "pose": on_link(model, e.link, &e.pose),
        })).collect::<Vec<_>>(),
        "uncollided_pairs": robot.self_collision.ignore.iter().map(|p| p.map(link)).collect::<Vec<_>>(),
        // At home, base at the origin, for the velocities (linear and angular of the base in world axes, joints).
        "mass_matrix": rows,
        "notices": robot.notices.iter().map(|n| json!({
            "severity": if n.severity == Severity::Warning { "warning" } else { "note" },
            "message": n.message,
            "location": n.location(),
        })).collect::<Vec<_>>(),
    })
}

fn link_json(model: &Model, link: &Link) -> Value {
    let body = link.body().transformed(&link.urdf_frame.inverse());
    let tensor = [0, 1, 2].map(|row| [0, 1, 2].map(|column| body.tensor[(row, column)]));
    json!({
        "name": link.name,
        "parent": link.parent.map(|parent| model.links[parent.0].name.as_str()),
        "mass": body.mass,
        "com": vector(&body.com),
        // About the centre of mass, in the link's axes.
        "inertia": tensor,
        "welded": link.merged.iter().map(|m| json!({
            "name": m.name, "pose": pose(&(link.urdf_frame.inverse() * m.pose)),
        })).collect::<Vec<_>>(),
        "visuals": link.visuals.len(),
        "collisions": link.collisions.len(),
    })
}

fn joint_json(model: &Model, i: usize, joint: &Joint) -> Value {
    let link = &model.links[i + 1];
    let frame = link.urdf_frame.inverse();
    let limit = |x: f64| x.is_finite().then_some(x);
    let kind = match joint.kind {
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
    };
    let mode = match joint.drive.mode {
        DriveMode::Position => "position",
        DriveMode::Force => "force",
        DriveMode::Velocity => "velocity",
        DriveMode::Kinematic => "kinematic",
        DriveMode::Passive => "passive",
    };
    json!({
        "name": joint.name,
        "kind": kind,
        "link": link.name,
        "axis": vector(&(frame.rotation * Vector3::z())),
        "anchor": vector(&frame.translation.vector),
        "lower": limit(joint.lower),
        "upper": limit(joint.upper),
        "velocity_limit": limit(joint.velocity_limit),
        "effort_limit": limit(joint.effort_limit),
        "damping": joint.damping,
        "friction": joint.friction,
        "armature": joint.armature,
        "lag": joint.lag,
        "home": model.home[i],
        "drive": { "mode": mode, "kp": joint.drive.kp, "kd": joint.drive.kd, "configured": joint.drive_configured },
    })
}

/// Name of a kind of loop.
pub(super) fn loop_kind(kind: LoopKind) -> &'static str {
    match kind {
        LoopKind::Ball => "ball",
        LoopKind::Pin => "pin",
        LoopKind::Weld => "weld",
        LoopKind::Rod(_) => "rod",
    }
}

/// A pose in a link's internal frame, in the link's own frame.
fn on_link(model: &Model, link: LinkId, in_link: &Isometry3<f64>) -> Value {
    pose(&(model.links[link.0].urdf_frame.inverse() * in_link))
}

fn pose(pose: &Isometry3<f64>) -> Value {
    let q = pose.rotation;
    json!({ "position": vector(&pose.translation.vector), "quaternion": [q.w, q.i, q.j, q.k] })
}

fn vector(v: &Vector3<f64>) -> [f64; 3] {
    (*v).into()
}
