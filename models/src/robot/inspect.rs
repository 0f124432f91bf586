//! Text output of `runner inspect`.

use std::fmt::Write;

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::Robot;
use super::closure::LoopKind;
use super::inspect_json::loop_kind;
use super::link_poses::{centre_of_mass, link_poses};
use super::model::{Base, DriveMode, Joint, JointKind, Link, LinkId, Model};
use crate::math;
use crate::text::Severity;

/// Describes the robot for users, in the URDF's frames and SI units.
pub fn inspect(robot: &Robot) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = overview(&mut out, robot);
    let _ = links(&mut out, &robot.model);
    let _ = joints(&mut out, &robot.model);
    let _ = conditions(&mut out, &robot.model);
    let _ = transmissions(&mut out, &robot.model);
    let _ = soles(&mut out, &robot.model);
    let _ = frames(&mut out, &robot.model);
    let _ = notices(&mut out, robot);
    out
}

fn overview(out: &mut String, robot: &Robot) -> std::fmt::Result {
    let model = &robot.model;
    let poses = link_poses(model, &model.home);
    let base = match model.base {
        Base::Floating => "floating",
        Base::Fixed => "fixed",
    };
    writeln!(out, "robot {}", model.name)?;
    for (path, bytes) in &robot.files {
        writeln!(out, "  file                {} ({} bytes)", path.display(), bytes.len())?;
    }
    writeln!(out, "  base                {base}, root link {}", model.links[0].name)?;
    let conditions = [(model.couplings.len(), "coupling"), (model.loops.len(), "loop")];
    let counted = conditions.into_iter().filter(|(n, _)| *n > 0);
    let counted = counted.map(|(n, what)| format!("{n} {what}{}", if n == 1 { "" } else { "s" })).collect::<Vec<_>>();
    // Conditions may depend on each other: how many they remove is not known here.
    let before = if counted.is_empty() { String::new() } else { format!(", before {}", counted.join(" and ")) };
    let (all, base, joints) = (model.nv(), model.nb(), model.nj());
    writeln!(out, "  degrees of freedom  {all} ({base} base, {joints} joints{before})")?;
    writeln!(out, "  mass                {} kg", number(model.mass()))?;
    writeln!(out, "  centre of mass      {} m at home, in the root frame", vector(&centre_of_mass(model, &poses)))?;
    let lowest = model.soles.iter().flat_map(|s| s.vertices.iter().map(|v| (poses[s.link.0] * Point3::from(*v)).z));
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() {
        writeln!(out, "  home stance         root frame {} m above the lowest sole vertex", number(-lowest))?;
    }
    Ok(())
}

fn links(out: &mut String, model: &Model) -> std::fmt::Result {
    writeln!(
        out,
        "\nlinks ({}): mass kg; centre of mass m; inertia about it xx yy zz xy xz yz kg m^2",
        model.links.len()
    )?;
    for link in &model.links {
        let (com, inertia) = in_urdf_frame(link);
        let i = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| number(inertia[at]));
        writeln!(out, "  {:<20} {:>10}  {}  {}", link.name, number(link.mass), vector(&com), i.join(" "))?;
        let counts = (link.visuals.len(), link.collisions.len());
        let welded: Vec<&str> = link.merged.iter().map(|m| m.name.as_str()).collect();
        write!(out, "  {:<20} {} visual, {} collision shapes", "", counts.0, counts.1)?;
        if !welded.is_empty() {
            write!(out, "; welded on: {}", welded.join(", "))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn joints(out: &mut String, model: &Model) -> std::fmt::Result {
    writeln!(
        out,
        "\njoints ({}): kind, axis in the child's frame; range; effort, velocity; friction; home; drive",
        model.nj()
    )?;
    for (i, joint) in model.joints.iter().enumerate() {
        let link = &model.links[i + 1];
        let axis = link.urdf_frame.rotation.inverse() * Vector3::z();
        let (kind, angle) = match joint.kind {
            JointKind::Revolute => ("revolute", "rad"),
            JointKind::Continuous => ("continuous", "rad"),
            JointKind::Prismatic => ("prismatic", "m"),
        };
        writeln!(
            out,
            "  {:<20} {kind} about {}; {}; {}, {}; {} + {} v; {}; {}",
            joint.name,
            vector(&axis),
            range(joint, angle),
            number(joint.effort_limit),
            number(joint.velocity_limit),
            number(joint.friction),
            number(joint.damping),
            number(model.home[i]),
            drive(joint)
        )?;
    }
    Ok(())
}

/// Keyframes, couplings and loops; nothing when there are none.
fn conditions(out: &mut String, model: &Model) -> std::fmt::Result {
    if !model.keyframes.is_empty() {
        writeln!(out, "\nkeyframes ({}): positions of the joints in their order, rad or m", model.keyframes.len())?;
    }
    for keyframe in &model.keyframes {
        let joints: Vec<String> = keyframe.joints.iter().map(|q| number(*q)).collect();
        writeln!(out, "  {:<20} {}", keyframe.name, joints.join(" "))?;
    }
    if !model.couplings.is_empty() {
        writeln!(out, "\ncouplings ({}): position of a joint by that x of another", model.couplings.len())?;
    }
    for coupling in &model.couplings {
        let terms = coupling.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
        let terms: Vec<String> = terms
            .map(|(power, c)| match power {
                0 => number(*c),
                1 => format!("{} x", number(*c)),
                _ => format!("{} x^{power}", number(*c)),
            })
            .collect();
        let polynomial = if terms.is_empty() { "0".into() } else { terms.join(" + ") };
        let (joint, leader) = (&model.joints[coupling.joint.0].name, &model.joints[coupling.leader.0].name);
        writeln!(out, "  {joint:<20} = {polynomial}, x of {leader}")?;
    }
    if !model.loops.is_empty() {
        writeln!(out, "\nloops ({}): kind; origins of both frames in their links' frames, m", model.loops.len())?;
    }
    for closure in &model.loops {
        let origin = |link: LinkId, pose: &Isometry3<f64>| {
            let link = &model.links[link.0];
            format!("{} at {}", link.name, vector(&(link.urdf_frame.inverse() * pose).translation.vector))
        };
        let world = || format!("the world at {}", vector(&closure.other_pose.translation.vector));
        let length = match closure.kind {
            LoopKind::Rod(length) => format!(" of {} m", number(length)),
            _ => String::new(),
        };
        writeln!(
            out,
            "  {:<20} {}{length}: {}, {}",
            closure.name,
            loop_kind(closure.kind),
            origin(closure.link, &closure.pose),
            closure.other.map_or_else(world, |other| origin(other, &closure.other_pose))
        )?;
    }
    Ok(())
}

fn range(joint: &Joint, unit: &str) -> String {
    if (joint.lower, joint.upper) == (f64::NEG_INFINITY, f64::INFINITY) {
        return "unlimited".into();
    }
    format!("{} to {} {unit}", number(joint.lower), number(joint.upper))
}

fn drive(joint: &Joint) -> String {
    let mut armature = format!("armature {}", number(joint.armature));
    if joint.lag > 0.0 {
        let _ = write!(armature, ", lag {} s", number(joint.lag));
    }
    let (kp, kd) = (number(joint.drive.kp), number(joint.drive.kd));
    match joint.drive.mode {
        _ if !joint.drive_configured => format!("drive not configured, {armature}"),
        DriveMode::Position => format!("position kp {kp} kd {kd}, {armature}"),
        DriveMode::Force => format!("force, {armature}"),
        DriveMode::Velocity => format!("velocity kd {kd}, {armature}"),
        DriveMode::Kinematic => format!("kinematic, {armature}"),
        DriveMode::Passive => format!("passive, {armature}"),
    }
}

/// Gears and motors; nothing when there are none.
fn transmissions(out: &mut String, model: &Model) -> std::fmt::Result {
    if model.transmissions.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "\ntransmissions ({}): joints; of each motor: speed by those of the joints; rotor inertia kg m^2; effort, \
         velocity; friction",
        model.transmissions.len()
    )?;
    for of in &model.transmissions {
        let names: Vec<&str> = of.joints.iter().map(|id| model.joints[id.0].name.as_str()).collect();
        writeln!(out, "  {:<20} {}", of.name, names.join(", "))?;
        let limit = |limits: &Option<Vec<f64>>, k: usize| {
            limits.as_ref().map_or("unlimited".into(), |limits| number(limits[k]))
        };
        for (k, inertia) in of.rotor_inertia.iter().enumerate() {
            let row: Vec<String> = (0..of.number()).map(|j| number(of.ratio(k, j))).collect();
            let (effort, velocity) = (limit(&of.effort_limit, k), limit(&of.velocity_limit, k));
            let friction = of.friction.as_ref().map_or((0.0, 0.0), |laws| (laws[k].coulomb, laws[k].viscous));
            let friction = format!("{} + {} v", number(friction.0), number(friction.1));
            let (row, inertia) = (row.join(" "), number(*inertia));
            writeln!(out, "  {:<20} [{row}]; {inertia}; {effort}, {velocity}; {friction}", "")?;
        }
    }
    Ok(())
}

fn soles(out: &mut String, model: &Model) -> std::fmt::Result {
    writeln!(out, "\nsoles ({}): polygons in the link's frame, m", model.soles.len())?;
    for sole in &model.soles {
        let link = &model.links[sole.link.0];
        let back = link.urdf_frame.inverse();
        let polygon: Vec<String> = sole.vertices.iter().map(|v| vector(&(back * Point3::from(*v)).coords)).collect();
        writeln!(out, "  {:<20} on {}: {}", sole.name, link.name, polygon.join(" "))?;
    }
    Ok(())
}

/// End effectors and sensors; nothing when there are none.
fn frames(out: &mut String, model: &Model) -> std::fmt::Result {
    let effectors = model.end_effectors.iter().map(|e| ("end effector", &e.name, e.link, &e.pose));
    let imus = model.sensors.imu.iter().map(|s| ("IMU", &s.name, s.mount.link, &s.mount.pose));
    let forces = model.sensors.force.iter().map(|s| ("force sensor", &s.name, s.mount.link, &s.mount.pose));
    let frames: Vec<_> = effectors.chain(imus).chain(forces).collect();
    if frames.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nframes ({}): origin m, roll pitch yaw rad, in the link's frame", frames.len())?;
    for (kind, name, link, pose) in frames {
        let link = &model.links[link.0];
        let own = link.urdf_frame.inverse() * pose;
        let (roll, pitch, yaw) = own.rotation.euler_angles();
        let (origin, rpy) = (vector(&own.translation.vector), vector(&Vector3::new(roll, pitch, yaw)));
        let label = format!("{kind} {name}");
        writeln!(out, "  {label:<26} on {}: {origin}, rpy {rpy}", link.name)?;
    }
    Ok(())
}

fn notices(out: &mut String, robot: &Robot) -> std::fmt::Result {
    let warnings = robot.notices.iter().filter(|n| n.severity == Severity::Warning).count();
    writeln!(out, "\nnotices ({}, of which {warnings} warnings)", robot.notices.len())?;
    for notice in &robot.notices {
        writeln!(out, "  {}", notice.brief())?;
    }
    for joint in robot.model.joints.iter().filter(|j| !j.drive_configured) {
        writeln!(out, "  note: joint `{}` has no drive: a scenario's joint_default decides", joint.name)?;
    }
    Ok(())
}

/// Centre and tensor in the axes of the link's URDF frame.
fn in_urdf_frame(link: &Link) -> (Vector3<f64>, Matrix3<f64>) {
    let back: Isometry3<f64> = link.urdf_frame.inverse();
    let r = back.rotation.to_rotation_matrix().into_inner();
    ((back * Point3::from(link.com)).coords, r * link.inertia * r.transpose())
}

/// At most six significant digits; values that are zero up to rounding are shown as 0.
fn number(x: f64) -> String {
    if x.abs() < 1e-15 {
        return "0".into();
    }
    if !x.is_finite() {
        return if x > 0.0 { "unlimited".into() } else { "-unlimited".into() };
    }
    let digits = (5 - math::log10(x.abs()).floor() as i32).max(0) as usize;
    if digits > 12 {
        return format!("{x:.5e}");
    }
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

fn vector(v: &Vector3<f64>) -> String {
    format!("[{} {} {}]", number(v.x), number(v.y), number(v.z))
}
