//! Assembles a [`Setup`] from a scenario's run and a loaded robot: resolves names, and reports
//! values that do not fit the robot.
//!
//! Imports: `math`, `text`, `geometry`, `integrate`, `random`, `mesh`, `robot`, `terrain`,
//! `dynamics`, `motion`, `patches`, `contact`, `collision`, `task`, `force`, `script`, `policy`, `scenario`, `sim`,
//! `log`. Used by: `batch`, `console`, `fit`, `api`.

mod balance;
mod bodies;
mod closed_start;
mod contact_pairs;
mod events;
mod forces;
mod friction;
pub mod log_size;
mod mocap;
mod model;
mod names;
pub mod object_models;
mod objects;
mod pairing;
mod planned;
mod playback;
mod policy;
mod script_setup;
mod self_contact;
mod sensors;
mod start;
mod start_height;
mod tasks;
pub mod terrain;

use self::friction::extra;
use self::start_height::Ground;
use crate::contact::model::problem::Tolerances;
use crate::contact::model::state::SoleState;
use crate::geometry::Plane;
use crate::integrate::{BS23, DOPRI5, RK4};
use crate::math;
use crate::robot::{Model, Robot, SoleId};
use crate::scenario::{
    Diagnostic, Diagnostics, EventHandling, FloorSpec, IntegratorMethod, IntegratorSpec, Interpolation, JointLimits,
    PatchSpec, Run, SunkLink, TouchingParts,
};
use crate::sim::Floor;
use crate::sim::actuation::kinematic_paths::Interpolation as Paths;
use crate::sim::floor::{LinkHull, Patch};
use crate::sim::setup::{ContactSetup, Forced, ImplicitSteps, IntegratorSetup, Setup};
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

/// Builds the setup of a run, whose objects' models it loads from their files.
///
/// # Errors
/// Each joint, link, sole or value of the scenario that does not fit the robot, with its position
/// in the file; a model of an object that cannot be loaded.
pub fn setup(run: &Run, robot: &Robot) -> Result<Setup, Diagnostics> {
    setup_with(run, robot, &object_models::load(run)?)
}

/// As [`setup`], with the loaded models of the run's objects, in their order.
///
/// # Errors
/// See [`setup`].
pub fn setup_with(run: &Run, robot: &Robot, models: &[Arc<Robot>]) -> Result<Setup, Diagnostics> {
    let (mut notes, mut errors) = (Vec::new(), Vec::new());
    let model = model::adjusted_model(run, robot, &mut errors);
    let s = &run.scenario;
    let floor = floor(run, &mut errors);
    let plane = s.floor.plane.then_some(Plane { rotation: floor.rotation, point: floor.point });
    let terrain = terrain::terrain(run, plane, &mut notes, &mut errors);
    let touching_links = (s.robot.contact == TouchingParts::Bodies && s.floor.plane).then(|| {
        LinkHull::of_model(&model, robot.self_collision.resolution, |link, shape| {
            bodies::rolls_on_floor(&model, link, shape)
        })
    });
    let touching = bodies::robot_bodies(&model, run, robot.self_collision.resolution);
    let hulls = touching_links.as_deref();
    let ground = Ground { floor: &floor, terrain: &terrain, hulls, bodies: &touching };
    let start = start::start(run, &model, &ground, &mut errors);
    let objects = objects::objects(run, models, &mut notes, &mut errors);
    let forces = forces::forces(run, &model, &objects, &mut errors);
    let carried_objects = forces::loads(run, &model, &mut errors);
    let tasks = tasks::tasks(run, &model, &start, &mut notes, &mut errors);
    let self_collision = self_contact::self_contact(run, robot, &model, &start, &mut notes, &mut errors);
    let contact = ContactSetup {
        method: s.contact.method.descriptor().with(s.contact.parameters()),
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
    let pair_rules = contact_pairs::rules(run, &model, &objects, &mut errors);
    let integrator = integrator(&s.integrator);
    let imu = sensors::imu(run, &model, &mut errors);
    let estimator = sensors::estimator(run, &model, &mut errors);
    pairing::check(run, &mut errors);
    pairing::check_soles(run, &model, &mut errors);
    check_facets(run, &model, &mut errors);
    log_size::check(run, &model, &mut errors);
    // Errors at the start would be reported again for each event.
    let (events, saved_states) =
        if errors.is_empty() { events::changes(run, robot, &model, &objects, &mut errors) } else { Default::default() };
    if !errors.is_empty() {
        return Err(Diagnostics(names::limit_errors(errors)));
    }
    if !floor.is_absent
        && let Some(error) = start::below_floor(run, &model, &floor, &start, touching_links.as_deref())
    {
        return Err(Diagnostics(vec![error]));
    }
    let own = if s.robot.self_contact {
        contact_pairs::own_pairs(robot, &model, &start, &touching, &mut notes)
    } else {
        Vec::new()
    };
    let meets_floor = touching.iter().any(|body| body.meets_floor);
    let may_touch = meets_floor || !objects.is_empty() || !terrain.is_empty() || !own.is_empty();
    let bodies = if may_touch {
        bodies::bodies(&model, touching, &own, &floor, &objects, &pair_rules)
    } else {
        Default::default()
    };
    if let Some(error) = bodies::overlap(run, &model, &start, &objects, &bodies, &terrain, &pair_rules) {
        return Err(Diagnostics(vec![error]));
    }
    Ok(Setup {
        events,
        saved_states,
        model: Arc::new(model),
        gravity: s.gravity.into(),
        floor,
        terrain: Arc::new(terrain),
        contact,
        integrator,
        start,
        joint_stops: s.robot.joint_limits == JointLimits::Stop,
        interpolation: match s.control.interpolation {
            Interpolation::Hold => Paths::Hold,
            Interpolation::Cubic => Paths::Cubic,
            Interpolation::Continuous => Paths::Continuous,
        },
        tasks,
        command_source: None,
        forces,
        objects: objects.into_iter().map(|object| object.setup).collect(),
        bodies,
        pair_rules,
        carried_objects,
        sensors: sensors::errors(&s.sensors),
        imu,
        estimator,
        self_collision,
        seed: s.seed,
        duration: s.end(),
        log_rate: s.log.rate,
        log_instants: Vec::new(),
        fallen_below: s.stop.fallen.as_ref().map(|f| f.below),
        touching_links,
        ends_when_sunk: s.stop.sunk_link == SunkLink::Fallen && s.floor.plane,
        notes,
    })
}

fn floor(run: &Run, errors: &mut Vec<Diagnostic>) -> Floor {
    let spec = &run.scenario.floor;
    let rotation = Rotation3::from_euler_angles(spec.rpy[0], spec.rpy[1], spec.rpy[2]);
    let floor = Floor {
        rotation: *rotation.matrix(),
        point: Vector3::new(0.0, 0.0, spec.height),
        mu_s: spec.friction.static_,
        mu_k: spec.friction.kinetic,
        extra: extra(spec.friction),
        patches: patches(spec),
        is_absent: !spec.plane,
    };
    if !floor.patches.is_empty() && floor.rotation[(2, 2)].abs() < MIN_TILT_COSINE {
        let message = "`floor.patches` are projected vertically, but this floor is vertical: see `floor.rpy`";
        errors.push(run.error_at("floor.patches", message, None));
    }
    floor
}

/// Greatest number of unknowns of a method's densest problem. Its matrix takes 8 bytes times their
/// square.
const MAX_UNKNOWNS: usize = 4096;

/// Refuses friction directions whose problem would take too much memory.
fn check_facets(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) {
    let contact = &run.scenario.contact;
    let vertices = model.soles.iter().map(|s| s.vertices.len()).sum();
    let Some(unknowns) = contact.method.descriptor().unknowns else { return };
    let unknowns = unknowns(&contact.parameters(), vertices);
    if unknowns > MAX_UNKNOWNS {
        let message = format!(
            "`contact.lcp.facets` = {} makes {unknowns} unknowns of the {vertices} vertices of the robot's soles; at \
             most {MAX_UNKNOWNS} are allowed",
            contact.lcp.facets
        );
        errors.push(run.error_at("contact.lcp.facets", message, None));
    }
}

/// Cosine of the tilt beyond which no point can be projected vertically onto the floor.
const MIN_TILT_COSINE: f64 = 1e-6;

fn patches(floor: &FloorSpec) -> Vec<Patch> {
    let patch = |p: &PatchSpec| Patch {
        corners: p.polygon.iter().map(|&c| c.into()).collect(),
        mu_s: p.friction.static_,
        mu_k: p.friction.kinetic,
        extra: extra(p.friction),
    };
    floor.patches.iter().map(patch).collect()
}

fn integrator(spec: &IntegratorSpec) -> IntegratorSetup {
    let controlled = |pair, implicit| IntegratorSetup::Controlled {
        pair,
        implicit,
        relative: spec.relative_tolerance,
        absolute: spec.absolute_tolerance,
        max_step: spec.max_step,
    };
    match spec.method {
        IntegratorMethod::Dopri5 => controlled(&DOPRI5, ImplicitSteps::Never),
        IntegratorMethod::Rosenbrock => controlled(&DOPRI5, ImplicitSteps::Rosenbrock),
        IntegratorMethod::Bdf => controlled(&DOPRI5, ImplicitSteps::Bdf),
        IntegratorMethod::Auto => controlled(&DOPRI5, ImplicitSteps::Auto),
        IntegratorMethod::Bs23 => controlled(&BS23, ImplicitSteps::Never),
        IntegratorMethod::Rk4 => IntegratorSetup::Stepped { method: &RK4, step: spec.step },
        IntegratorMethod::SemiImplicit => IntegratorSetup::SemiImplicit { step: spec.step },
    }
}

/// Slip speeds that the integrator cannot distinguish from rest: ten times its absolute tolerance;
/// for steps h without control 1e3 h^4, the error of order 4 in velocities that change within some
/// tenths of a second. Velocity-level steps resolve zero itself, because friction there is an
/// impulse that may stop a vertex within the step.
fn rest_speed(run: &Run) -> f64 {
    let spec = &run.scenario.integrator;
    let unresolved = match spec.method {
        IntegratorMethod::Dopri5
        | IntegratorMethod::Rosenbrock
        | IntegratorMethod::Bdf
        | IntegratorMethod::Auto
        | IntegratorMethod::Bs23 => 10.0 * spec.absolute_tolerance,
        IntegratorMethod::Rk4 => 1e3 * math::powi(spec.step, 4),
        IntegratorMethod::SemiImplicit => return 1e-9,
    };
    unresolved.clamp(1e-10, 1e-4)
}

fn forced(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<Forced> {
    let mut forced = Vec::new();
    for (i, spec) in run.scenario.contact.forced.iter().enumerate() {
        let path = format!("contact.forced.{i}.sole");
        let Some(SoleId(sole)) = names::sole(model, run, &path, &spec.sole, errors) else { continue };
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
