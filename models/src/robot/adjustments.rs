//! Changes a loaded robot as a scenario requires. Each function checks all values before it changes
//! the model.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Vector3};

use super::link_poses::link_poses;
use super::model::{Drive, DriveMode, JointId, LinkId, Model, Sole};
use super::rigid_inertia::{Flaw, RigidInertia, examine, moments_text};
use super::robot_error::RobotError;
use crate::geometry::convex_polygon;
use crate::text::suggest::nearest;

/// Changes of one joint; `None` keeps a value. Units as in [`super::Joint`].
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct DriveSettings {
    /// Drive mode. When `None` and a gain is given, an unconfigured joint becomes
    /// position-controlled.
    pub mode: Option<DriveMode>,
    /// Position gain.
    pub kp: Option<f64>,
    /// Velocity gain.
    pub kd: Option<f64>,
    /// Greatest effort.
    pub effort: Option<f64>,
    /// Greatest speed.
    pub velocity: Option<f64>,
    /// Coulomb friction.
    pub coulomb: Option<f64>,
    /// Viscous friction.
    pub viscous: Option<f64>,
    /// Static friction.
    pub static_friction: Option<f64>,
    /// Speed over which static friction falls to Coulomb friction.
    pub stribeck_velocity: Option<f64>,
    /// Speed below which friction is below its full size.
    pub slip_velocity: Option<f64>,
    /// Stiffness and damping of the end stops.
    pub stop: Option<(f64, f64)>,
    /// Reflected rotor inertia.
    pub armature: Option<f64>,
    /// Time constant of the actuator.
    pub lag: Option<f64>,
}

impl DriveSettings {
    /// These settings, completed from `other`.
    pub fn or(self, other: Self) -> Self {
        Self {
            mode: self.mode.or(other.mode),
            kp: self.kp.or(other.kp),
            kd: self.kd.or(other.kd),
            effort: self.effort.or(other.effort),
            velocity: self.velocity.or(other.velocity),
            coulomb: self.coulomb.or(other.coulomb),
            viscous: self.viscous.or(other.viscous),
            static_friction: self.static_friction.or(other.static_friction),
            stribeck_velocity: self.stribeck_velocity.or(other.stribeck_velocity),
            slip_velocity: self.slip_velocity.or(other.slip_velocity),
            stop: self.stop.or(other.stop),
            armature: self.armature.or(other.armature),
            lag: self.lag.or(other.lag),
        }
    }

    fn configures_drive(&self) -> bool {
        self.mode.is_some() || self.kp.is_some() || self.kd.is_some()
    }
}

/// A sole as users specify it.
#[derive(Clone, PartialEq, Debug)]
pub struct SolePolygon {
    /// Name, unique in the robot.
    pub name: String,
    /// Carrying link; it may be welded to another one.
    pub link: String,
    /// Vertices in order, in that link's URDF frame, m.
    pub polygon: Vec<Vector3<f64>>,
}

/// Sets drive, limits and friction of the joint named `joint`. Errors: unknown joint; a number
/// negative or not finite; position mode without a position gain, velocity mode without a velocity
/// gain.
pub fn set_drive(model: &mut Model, joint: &str, settings: &DriveSettings) -> Result<(), RobotError> {
    let JointId(index) =
        model.joint(joint).ok_or_else(|| unknown_name("joint", joint, model.joints.iter().map(|j| j.name.as_str())))?;
    configure(model, index, settings)
}

/// Applies `settings` to every joint that nothing configured yet (`joint_default` of a scenario).
/// Errors as [`set_drive`].
pub fn set_default_drive(model: &mut Model, settings: &DriveSettings) -> Result<(), RobotError> {
    for index in 0..model.joints.len() {
        if !model.joints[index].drive_configured {
            configure(model, index, settings)?;
        }
    }
    Ok(())
}

fn configure(model: &mut Model, index: usize, s: &DriveSettings) -> Result<(), RobotError> {
    if let Some(coupling) = model.coupling_of(JointId(index)).filter(|_| s.mode == Some(DriveMode::Kinematic)) {
        let leader = &model.joints[coupling.leader.0].name;
        let subject = format!("mode of joint `{}`", model.joints[index].name);
        return Err(bad_value(subject, "kinematic", &format!("another mode: the joint follows `{leader}`")));
    }
    check_transmission(model, index, s)?;
    let joint = &mut model.joints[index];
    // Name, value, and whether 0 is allowed.
    let values = [
        ("kp", s.kp, true),
        ("kd", s.kd, true),
        ("effort", s.effort, true),
        ("velocity", s.velocity, true),
        ("friction.coulomb", s.coulomb, true),
        ("friction.viscous", s.viscous, true),
        ("friction.static", s.static_friction, true),
        ("stop.damping", s.stop.map(|s| s.1), true),
        ("armature", s.armature, true),
        ("lag", s.lag, true),
        ("friction.stribeck_velocity", s.stribeck_velocity, false),
        ("friction.slip_velocity", s.slip_velocity, false),
        ("stop.stiffness", s.stop.map(|s| s.0), false),
    ];
    for (name, value, may_be_zero) in values {
        let is_valid = |x: f64| x.is_finite() && (x > 0.0 || may_be_zero && x == 0.0);
        if let Some(value) = value.filter(|x| !is_valid(*x)) {
            let expected = if may_be_zero { "a finite number, not negative" } else { "a finite number above 0" };
            return Err(bad_value(format!("{name} of joint `{}`", joint.name), value, expected));
        }
    }
    let coulomb = s.coulomb.unwrap_or(joint.friction);
    if let Some(value) = s.static_friction.filter(|s| *s > 0.0 && *s < coulomb) {
        let subject = format!("friction.static of joint `{}`", joint.name);
        return Err(bad_value(subject, value, &format!("at least friction.coulomb, {coulomb}")));
    }
    let implied = if joint.drive_configured { joint.drive.mode } else { DriveMode::Position };
    let mode = match s.mode {
        Some(mode) => mode,
        None if s.configures_drive() => implied,
        None => joint.drive.mode,
    };
    let drive = Drive { mode, kp: s.kp.unwrap_or(joint.drive.kp), kd: s.kd.unwrap_or(joint.drive.kd) };
    if s.configures_drive() && mode == DriveMode::Position && drive.kp == 0.0 {
        return Err(bad_value(
            format!("position drive of joint `{}`", joint.name),
            "kp = 0",
            "a position gain kp above 0",
        ));
    }
    if s.configures_drive() && mode == DriveMode::Velocity && drive.kd == 0.0 {
        return Err(bad_value(
            format!("velocity drive of joint `{}`", joint.name),
            "kd = 0",
            "a velocity gain kd above 0",
        ));
    }
    joint.drive = drive;
    joint.drive_configured |= s.configures_drive();
    joint.effort_limit = s.effort.unwrap_or(joint.effort_limit);
    joint.velocity_limit = s.velocity.unwrap_or(joint.velocity_limit);
    joint.friction = coulomb;
    joint.static_friction = s.static_friction.unwrap_or(joint.static_friction);
    joint.stribeck_velocity = s.stribeck_velocity.unwrap_or(joint.stribeck_velocity);
    joint.slip_velocity = s.slip_velocity.unwrap_or(joint.slip_velocity);
    joint.stop = s.stop.or(joint.stop);
    joint.damping = s.viscous.unwrap_or(joint.damping);
    joint.armature = s.armature.unwrap_or(joint.armature);
    joint.lag = s.lag.unwrap_or(joint.lag);
    Ok(())
}

/// Refuses settings that belong to the motors of the transmission that couples the joint with others.
fn check_transmission(model: &Model, index: usize, s: &DriveSettings) -> Result<(), RobotError> {
    let Some(of) = model.coupled_transmission_of(JointId(index)) else { return Ok(()) };
    let has_friction = of.friction.is_some();
    let has_rotors = of.rotor_inertia.iter().any(|inertia| *inertia > 0.0);
    for (name, value, is_of_motors) in [
        ("effort", s.effort, of.effort_limit.is_some()),
        ("velocity", s.velocity, of.velocity_limit.is_some()),
        ("armature", s.armature, has_rotors),
        ("friction.coulomb", s.coulomb, has_friction),
        ("friction.viscous", s.viscous, has_friction),
        ("friction.static", s.static_friction, has_friction),
    ] {
        if let Some(value) = value.filter(|_| is_of_motors) {
            let subject = format!("{name} of joint `{}`", model.joints[index].name);
            let expected = format!("none: transmission `{}` of the robot file gives that of its motors", of.name);
            return Err(bad_value(subject, value, &expected));
        }
    }
    Ok(())
}

/// Replaces all soles; an empty slice leaves the robot without contact. A polygon that runs
/// clockwise seen from above at the home posture is reversed, with the same first vertex. Errors:
/// unknown link, name used twice, polygon not flat, convex and in order.
pub fn set_soles(model: &mut Model, soles: &[SolePolygon]) -> Result<(), RobotError> {
    let poses = link_poses(model, &model.home);
    let mut new: Vec<Sole> = Vec::with_capacity(soles.len());
    for spec in soles {
        if new.iter().any(|s| s.name == spec.name) {
            return Err(bad_value(format!("sole `{}`", spec.name), "the name is used twice", "a unique name"));
        }
        new.push(make_sole(model, &poses, spec)?.0);
    }
    model.soles = new;
    Ok(())
}

/// The sole, and whether its vertices were reversed. `poses` are those of the internal frames at
/// home.
pub(super) fn make_sole(
    model: &Model,
    poses: &[Isometry3<f64>],
    spec: &SolePolygon,
) -> Result<(Sole, bool), RobotError> {
    let (link, frame) = find_link(model, &spec.link)?;
    convex_polygon::check(&spec.polygon).map_err(|defect| {
        bad_value(format!("polygon of sole `{}`", spec.name), defect, "a flat convex polygon, points in order")
    })?;
    let mut vertices: Vec<Vector3<f64>> = spec.polygon.iter().map(|p| (frame * Point3::from(*p)).coords).collect();
    let upward = (poses[link.0].rotation * convex_polygon::area_vector(&vertices)).z;
    let clockwise = vertices.len() > 2 && upward < 0.0;
    if clockwise {
        vertices[1..].reverse();
    }
    Ok((Sole { name: spec.name.clone(), link, vertices }, clockwise))
}

/// Welds a load to the link named `link`: mass (kg), centre of mass `position` (m) in the link's
/// URDF frame, and inertia `[ixx, iyy, izz, ixy, ixz, iyz]` (kg m^2) about that centre in the same
/// axes; all zeros is a point mass. Errors: unknown link, mass not above 0, a tensor no body can
/// have.
pub fn add_payload(
    model: &mut Model,
    link: &str,
    mass: f64,
    position: Vector3<f64>,
    inertia: [f64; 6],
) -> Result<(), RobotError> {
    let (id, frame) = find_link(model, link)?;
    let load = load_in(&frame, link, mass, Translation3::from(position).into(), inertia)?;
    let target = &mut model.links[id.0];
    target.set_body(&target.body().plus(&load));
    Ok(())
}

/// A load in the frame called `name` that has the pose `frame` in the link that carries it, as seen
/// from that link's internal frame: mass (kg), pose of its centre of mass and axes in the named
/// frame, and inertia `[ixx, iyy, izz, ixy, ixz, iyz]` (kg m^2) in those axes. Errors:
/// [`RobotError::BadValue`] for what no body can have.
pub fn load_in(
    frame: &Isometry3<f64>,
    name: &str,
    mass: f64,
    pose: Isometry3<f64>,
    inertia: [f64; 6],
) -> Result<RigidInertia, RobotError> {
    let subject = |what: &str| format!("{what} of the payload on `{name}`");
    if !(mass.is_finite() && mass > 0.0) {
        return Err(bad_value(subject("mass"), mass, "a finite number above 0"));
    }
    let position = pose.translation.vector;
    if !position.iter().all(|x| x.is_finite()) {
        return Err(bad_value(subject("position"), format!("{:?}", position.as_slice()), "finite numbers"));
    }
    let [ixx, iyy, izz, ixy, ixz, iyz] = inertia;
    if !inertia.iter().all(|x| x.is_finite()) {
        return Err(bad_value(subject("inertia"), format!("{inertia:?}"), "finite numbers"));
    }
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    let (moments, flaw) = examine(&tensor);
    if matches!(flaw, Some(Flaw::Negative | Flaw::Triangle)) {
        let expected = "principal moments not negative, the largest at most the sum of the others";
        return Err(bad_value(subject("inertia"), moments_text(moments), expected));
    }
    let load = RigidInertia { mass, com: Vector3::zeros(), tensor };
    Ok(load.transformed(&(frame * pose)))
}

fn find_link(model: &Model, name: &str) -> Result<(LinkId, Isometry3<f64>), RobotError> {
    model.link(name).ok_or_else(|| unknown_name("link", name, link_names(model)))
}

/// All link names, welded ones included.
pub(super) fn link_names(model: &Model) -> impl Iterator<Item = &str> {
    model.links.iter().flat_map(|l| std::iter::once(l.name.as_str()).chain(l.merged.iter().map(|m| m.name.as_str())))
}

fn unknown_name<'a>(kind: &'static str, name: &str, known: impl IntoIterator<Item = &'a str>) -> RobotError {
    RobotError::UnknownName { kind, name: name.to_owned(), suggestion: nearest(name, known).map(str::to_owned) }
}

fn bad_value(subject: String, found: impl std::fmt::Display, expected: &str) -> RobotError {
    RobotError::BadValue { subject, found: found.to_string(), expected: expected.to_owned() }
}
