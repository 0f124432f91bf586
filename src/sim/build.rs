//! From a scenario's run and a loaded robot to a [`Setup`]: the place where names meet what they name.

use super::pairing;
use super::patch::Patch;
use super::setup::{ContactSetup, Floor, Forced, IntegratorSetup, Setup, Start};
use crate::contact::lcp::LcpParameters;
use crate::contact::method::Parameters;
use crate::contact::ncp::NcpParameters;
use crate::contact::penalty::PenaltyParameters;
use crate::contact::problem::Tolerances;
use crate::contact::state::SoleState;
use crate::dynamics::{State, Workspace, kinematics};
use crate::force::Force;
use crate::force::friction::{Joint, JointFriction, SLIP_SPEED};
use crate::force::profile::{Profile, Shape};
use crate::force::wrench::Wrench;
use crate::integrate::{BS23, DOPRI5, RK4};
use crate::robot::adjust::{self, DriveSettings};
use crate::robot::{Base, DriveMode, JointId, Model, Robot};
use crate::scenario::{
    ConstantForce, ContactMethod, ContactSpec, Diagnostic, Diagnostics, EventHandling, FloorSpec, ForceFrame,
    ForceSpec, IntegratorMethod, IntegratorSpec, JointLimits, JointMode, PatchSpec, Profile as ProfileSpec, PushForce,
    Run, SoleSpec, TaskSpec, suggest,
};
use crate::task::posture::Posture;
use crate::task::{Command, TaskServer};
use nalgebra::{Point3, Rotation3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// Builds the setup of a run.
///
/// # Errors
/// Every joint, link, sole or value of the scenario that does not fit the robot, each at its place in the file.
pub fn setup(run: &Run, robot: &Robot) -> Result<Setup, Diagnostics> {
    let mut errors = Vec::new();
    let model = adjusted(run, robot, &mut errors);
    let s = &run.scenario;
    let rotation = Rotation3::from_euler_angles(s.floor.rpy[0], s.floor.rpy[1], s.floor.rpy[2]);
    let floor = Floor {
        rotation: *rotation.matrix(),
        point: Vector3::new(0.0, 0.0, s.floor.height),
        mu_s: s.floor.friction.static_,
        mu_k: s.floor.friction.kinetic,
        patches: patches(&s.floor),
    };
    if !floor.patches.is_empty() && floor.rotation[(2, 2)].abs() < STEEPEST {
        let message = "`floor.patches` are seen from above, and this floor stands upright: see `floor.rpy`";
        errors.push(run.error_at("floor.patches", message, None));
    }
    let start = start(run, &model, &floor, &mut errors);
    let forces = forces(run, &model, &mut errors);
    let mut tasks = TaskServer::new(s.control.rate, Command::hold(&start.joints));
    for (i, task) in s.task.iter().enumerate() {
        let TaskSpec::Posture(posture) = task;
        let targets = joints(&model, run, &format!("task.{i}.joints"), posture.joints.iter(), &mut errors);
        tasks.add(posture.start, Box::new(Posture::new(targets, posture.duration)));
    }
    let contact = ContactSetup {
        method: s.contact.method.name().to_owned(),
        parameters: parameters(&s.contact),
        tolerances: Tolerances {
            distance: s.contact.distance_tolerance,
            velocity: s.contact.velocity_tolerance,
            acceleration: s.contact.acceleration_tolerance,
            rest: rest_speed(run),
        },
        restitution: s.contact.restitution,
        locate: s.contact.events == EventHandling::Locate,
        forced: forced(run, &model, &mut errors),
    };
    let integrator = integrator(&s.integrator);
    pairing::check(run, &mut errors);
    facets(run, &model, &mut errors);
    if !errors.is_empty() {
        return Err(Diagnostics(errors));
    }
    Ok(Setup {
        model: Arc::new(model),
        gravity: s.gravity.into(),
        floor,
        contact,
        integrator,
        start,
        joint_stops: s.robot.joint_limits == JointLimits::Stop,
        tasks,
        forces,
        duration: s.duration,
        log_rate: s.log.rate,
        fallen_below: s.stop.fallen.as_ref().map(|f| f.below),
    })
}

fn parameters(spec: &ContactSpec) -> Parameters {
    let springs = &spec.penalty;
    Parameters {
        penalty: PenaltyParameters {
            stiffness: springs.stiffness,
            damping: springs.damping,
            slip_velocity: springs.slip_velocity,
        },
        lcp: LcpParameters { facets: spec.lcp.facets },
        ncp: NcpParameters { iterations: spec.ncp.iterations, tolerance: spec.ncp.tolerance },
    }
}

/// Unknowns of an `lcp` problem beyond which its dictionary (8 bytes times their square) takes too much memory.
const MOST_UNKNOWNS: usize = 4096;

/// Refuses more facets than memory holds.
fn facets(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) {
    let contact = &run.scenario.contact;
    let vertices = model.soles.iter().map(|s| s.vertices.len()).sum();
    let unknowns = parameters(contact).lcp.unknowns(vertices);
    if contact.method == ContactMethod::Lcp && unknowns > MOST_UNKNOWNS {
        let message = format!(
            "`contact.lcp.facets` = {} makes {unknowns} unknowns of the {vertices} vertices of the robot's soles; at \
             most {MOST_UNKNOWNS} are allowed",
            contact.lcp.facets
        );
        errors.push(run.error_at("contact.lcp.facets", message, None));
    }
}

/// Cosine of the tilt from which on nothing can be projected onto the floor from above.
const STEEPEST: f64 = 1e-6;

fn patches(floor: &FloorSpec) -> Vec<Patch> {
    let patch = |p: &PatchSpec| Patch {
        corners: p.polygon.iter().map(|&c| c.into()).collect(),
        mu_s: p.friction.static_,
        mu_k: p.friction.kinetic,
    };
    floor.patches.iter().map(patch).collect()
}

fn integrator(spec: &IntegratorSpec) -> IntegratorSetup {
    let controlled = |pair| IntegratorSetup::Controlled {
        pair,
        relative: spec.relative_tolerance,
        absolute: spec.absolute_tolerance,
        max_step: spec.max_step,
    };
    match spec.method {
        IntegratorMethod::Dopri5 => controlled(&DOPRI5),
        IntegratorMethod::Bs23 => controlled(&BS23),
        IntegratorMethod::Rk4 => IntegratorSetup::Stepped { method: &RK4, step: spec.step },
        IntegratorMethod::SemiImplicit => IntegratorSetup::SemiImplicit { step: spec.step },
    }
}

/// Slip speeds that the integrator cannot tell from rest: ten times its absolute tolerance; for steps h without control
/// 1e3 h^4, the error of order 4 in velocities that change within some tenths of a second. Velocity-level steps
/// resolve zero itself, because friction there is an impulse that may stop a vertex within the step.
fn rest_speed(run: &Run) -> f64 {
    let spec = &run.scenario.integrator;
    let unresolved = match spec.method {
        IntegratorMethod::Dopri5 | IntegratorMethod::Bs23 => 10.0 * spec.absolute_tolerance,
        IntegratorMethod::Rk4 => 1e3 * spec.step.powi(4),
        IntegratorMethod::SemiImplicit => return 1e-9,
    };
    unresolved.clamp(1e-10, 1e-4)
}

/// The robot's model with the scenario's changes.
fn adjusted(run: &Run, robot: &Robot, errors: &mut Vec<Diagnostic>) -> Model {
    let spec = &run.scenario.robot;
    let mut model = robot.model.clone();
    for (name, joint) in &spec.joint {
        let settings = DriveSettings {
            mode: joint.mode.map(mode),
            kp: joint.kp,
            kd: joint.kd,
            effort: joint.effort,
            coulomb: joint.friction.map(|f| f.coulomb),
            viscous: joint.friction.map(|f| f.viscous),
            ..DriveSettings::default()
        };
        if let Err(e) = adjust::set_drive(&mut model, name, &settings) {
            errors.push(run.error_at_key(&format!("robot.joint.{name}"), e.to_string(), None));
        }
    }
    let default = &spec.joint_default;
    let settings = DriveSettings {
        mode: Some(mode(default.mode)),
        kp: Some(default.kp),
        kd: Some(default.kd),
        ..DriveSettings::default()
    };
    if let Err(e) = adjust::set_default_drive(&mut model, &settings) {
        errors.push(run.error_at("robot.joint_default", e.to_string(), None));
    }
    if let Some(soles) = &spec.soles {
        let convert = |s: &SoleSpec| adjust::SoleSpec {
            name: s.name.clone(),
            link: s.link.clone(),
            polygon: s.polygon.iter().map(|&p| p.into()).collect(),
        };
        let soles: Vec<_> = soles.iter().map(convert).collect();
        if let Err(e) = adjust::set_soles(&mut model, &soles) {
            errors.push(run.error_at("robot.soles", e.to_string(), None));
        }
    }
    for (i, load) in spec.payload.iter().enumerate() {
        let added = adjust::add_payload(&mut model, &load.link, load.mass, load.position.into(), load.inertia);
        if let Err(e) = added {
            errors.push(run.error_at(&format!("robot.payload.{i}"), e.to_string(), None));
        }
    }
    model
}

fn mode(mode: JointMode) -> DriveMode {
    match mode {
        JointMode::Passive => DriveMode::Passive,
        JointMode::Position => DriveMode::Position,
        JointMode::Force => DriveMode::Force,
    }
}

/// Joint numbers of named values; unknown names are errors at their keys under `path`.
fn joints<'a>(
    model: &Model,
    run: &Run,
    path: &str,
    named: impl Iterator<Item = (&'a String, &'a f64)>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<(JointId, f64)> {
    let mut found = Vec::new();
    for (name, &value) in named {
        match model.joint(name) {
            Some(id) => found.push((id, value)),
            None => {
                let help = suggest(name, model.joints.iter().map(|j| j.name.as_str()));
                let message = format!("the robot `{}` has no joint `{name}`", model.name);
                errors.push(run.error_at_key(&format!("{path}.{name}"), message, Some(help)));
            }
        }
    }
    found
}

/// Initial state. Without a base position the robot stands: lowest sole vertex on the floor, straight above the
/// world's origin.
fn start(run: &Run, model: &Model, floor: &Floor, errors: &mut Vec<Diagnostic>) -> Start {
    let spec = &run.scenario.robot;
    let mut state = State::home(model);
    for (id, q) in joints(model, run, "robot.posture", spec.posture.iter(), errors) {
        state.joints[id.0] = q;
    }
    let nb = model.nb();
    for (id, qd) in joints(model, run, "robot.velocity", spec.velocity.iter(), errors) {
        state.v[nb + id.0] = qd;
    }
    let [roll, pitch, yaw] = spec.base.rpy;
    state.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    if model.base == Base::Floating {
        state.v[..3].copy_from_slice(&spec.base.linear_velocity);
        state.v[3..6].copy_from_slice(&spec.base.angular_velocity);
    }
    state.position = match spec.base.position {
        Some(p) => p.into(),
        None if model.base == Base::Fixed => Vector3::zeros(),
        None => {
            let mut ws = Workspace::new(model);
            kinematics::update(model, &state, &mut ws);
            let heights =
                model.soles.iter().flat_map(|sole| sole.vertices.iter().map(|v| floor.height(&ws.point(sole.link, v))));
            let lowest = heights.fold(f64::INFINITY, f64::min);
            let rise = if lowest.is_finite() { -lowest / floor.rotation[(2, 2)] } else { 0.0 };
            Vector3::new(0.0, 0.0, rise)
        }
    };
    Start { position: state.position, rotation: state.rotation, joints: state.joints, v: state.v }
}

fn forces(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<Box<dyn Force>> {
    let mut forces: Vec<Box<dyn Force>> = Vec::new();
    for (i, spec) in run.scenario.force.iter().enumerate() {
        match spec {
            ForceSpec::Push(PushForce { link, point, force, moment, frame, start, duration, profile }) => {
                let shape = match profile {
                    ProfileSpec::Constant => Shape::Constant,
                    ProfileSpec::HalfSine => Shape::HalfSine,
                    ProfileSpec::Ramp => Shape::Ramp,
                    ProfileSpec::Triangle => Shape::Triangle,
                };
                let profile = Profile::new(shape, *start, *duration);
                let made = wrench(run, model, i, link, [point, force, moment], *frame, profile, errors);
                forces.extend(made);
            }
            ForceSpec::Constant(ConstantForce { link, point, force, moment, frame, start, duration }) => {
                let always = *start == 0.0 && duration.is_none();
                let shape = if always { Shape::Always } else { Shape::Constant };
                let profile = Profile::new(shape, *start, duration.unwrap_or(f64::INFINITY));
                let made = wrench(run, model, i, link, [point, force, moment], *frame, profile, errors);
                forces.extend(made);
            }
            ForceSpec::JointFriction(spec) => {
                let unused: Vec<f64> = spec.joints.values().map(|_| 0.0).collect();
                joints(model, run, &format!("force.{i}.joints"), spec.joints.keys().zip(&unused), errors);
                let of = |(j, joint): (usize, &crate::robot::Joint)| {
                    spec.of(&joint.name).map(|f| Joint { joint: j, coulomb: f.coulomb, viscous: f.viscous })
                };
                let joints = model.joints.iter().enumerate().filter_map(of).collect();
                forces.push(Box::new(JointFriction { joints, slip_speed: SLIP_SPEED }));
            }
        }
    }
    forces
}

#[expect(clippy::too_many_arguments)]
fn wrench(
    run: &Run,
    model: &Model,
    i: usize,
    link: &str,
    [point, force, moment]: [&[f64; 3]; 3],
    frame: ForceFrame,
    profile: Profile,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let Some((id, pose)) = model.link(link) else {
        let names = model
            .links
            .iter()
            .flat_map(|l| std::iter::once(l.name.as_str()).chain(l.merged.iter().map(|m| m.name.as_str())));
        let help = suggest(link, names.collect::<Vec<_>>());
        let message = format!("the robot `{}` has no link `{link}`", model.name);
        errors.push(run.error_at(&format!("force.{i}.link"), message, Some(help)));
        return None;
    };
    Some(Box::new(Wrench {
        link: id,
        point: (pose * Point3::from(*point)).coords,
        force: (*force).into(),
        moment: (*moment).into(),
        axes: (frame == ForceFrame::Link).then_some(pose.rotation),
        profile,
    }))
}

fn forced(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<Forced> {
    let mut forced = Vec::new();
    for (i, spec) in run.scenario.contact.forced.iter().enumerate() {
        let Some(sole) = model.soles.iter().position(|s| s.name == spec.sole) else {
            let help = suggest(&spec.sole, model.soles.iter().map(|s| s.name.as_str()).collect::<Vec<_>>());
            let message = format!("the robot `{}` has no sole `{}`", model.name, spec.sole);
            errors.push(run.error_at(&format!("contact.forced.{i}.sole"), message, Some(help)));
            continue;
        };
        let k = model.soles[sole].vertices.len();
        let Some(state) = SoleState::all(k).find(|s| s.to_string() == spec.state) else {
            let message = format!("sole `{}` with {k} vertices has no state `{}`", spec.sole, spec.state);
            errors.push(run.error_at(&format!("contact.forced.{i}.state"), message, None));
            continue;
        };
        forced.push(Forced { sole, state, from: spec.from, to: spec.to.unwrap_or(f64::INFINITY) });
    }
    forced
}
