//! The initial state of the robot.

use crate::assemble::MIN_TILT_COSINE;
use crate::assemble::closed_start::{Given, close};
use crate::assemble::names::{Owner, check_range, joints, start_posture};
use crate::assemble::start_height::Ground;
use crate::dynamics::{State, Workspace, kinematics};
use crate::robot::{Base, LinkId, Model, Sole};
use crate::scenario::{Diagnostic, Run, SunkLink};
use crate::sim::Floor;
use crate::sim::floor::{LinkHull, SunkLinks};
use crate::sim::setup::Start;
use nalgebra::{UnitQuaternion, Vector3};

/// Greatest depth of a sole below the floor at the start, m, unless the distance tolerance is
/// greater: rounding, and the depth at which `penalty` carries a robot.
const SOLE_DEPTH: f64 = 1e-3;

/// Greatest depth of a link that touches, m: rounding of a position written with six decimals. The
/// corners of a face start in contact, others below the floor leave no valid state.
pub(super) const LINK_DEPTH: f64 = 1e-6;

/// Step to which a proposed height is rounded up, m, and the excess that is not: rounding.
const HEIGHT_STEP: f64 = 1e-6;
const HEIGHT_ROUNDING: f64 = 1e-9;

/// Initial state. Without a base position the robot stands above the world's origin, as low as floor and
/// terrain permit, or at it if a loop joins it to the world.
pub(super) fn start(run: &Run, model: &Model, ground: &Ground, errors: &mut Vec<Diagnostic>) -> Start {
    let floor = ground.floor;
    let spec = &run.scenario.robot;
    let mut state = State::home(model);
    let base = start_posture(Owner::robot(model), run, "robot.keyframe", spec.keyframe.as_ref(), errors);
    state.joints.copy_from_slice(&base);
    let posture = joints(model, run, "robot.posture", spec.posture.iter(), errors);
    for &(id, q) in &posture {
        let key = format!("robot.posture.{}", model.joints[id.0].name);
        check_range(run, model, &key, id, ("the initial posture", q, q), errors);
        state.joints[id.0] = q;
    }
    let nb = model.nb();
    let velocity = joints(model, run, "robot.velocity", spec.velocity.iter(), errors);
    for &(id, qd) in &velocity {
        state.v[nb + id.0] = qd;
    }
    let [roll, pitch, yaw] = spec.base.rpy;
    state.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    if model.base == Base::Floating {
        state.v[..3].copy_from_slice(&spec.base.linear_velocity);
        state.v[3..6].copy_from_slice(&spec.base.angular_velocity);
    }
    let given = Given {
        base: &base,
        posture: &posture,
        posture_key: "robot.posture",
        velocity: &velocity,
        velocity_key: "robot.velocity",
        model_key: "robot.model",
    };
    // A loop to the world needs the position, which depends on the posture otherwise.
    state.position = spec.base.position.map_or_else(Vector3::zeros, Vector3::from);
    close(run, model, &given, &mut state, errors);
    state.position = match spec.base.position {
        Some(p) => p.into(),
        None if model.base == Base::Fixed => Vector3::zeros(),
        None if floor.rotation[(2, 2)].abs() < MIN_TILT_COSINE => {
            let message = "the robot cannot start above this floor, which is vertical: see `floor.rpy`";
            let help = "give `base.position` in `[robot]`".to_owned();
            errors.push(run.error_at("floor.rpy", message, Some(help)));
            Vector3::zeros()
        }
        None if model.loops.iter().any(|closure| closure.other.is_none()) => Vector3::zeros(),
        None => Vector3::new(0.0, 0.0, ground.rise(model, &state)),
    };
    Start { position: state.position, rotation: state.rotation, joints: state.joints, v: state.v }
}

/// An error if a link or sole starts below the floor; `links` are those that touch it. Soles with an
/// imposed state are not checked, nor are runs of remote robots. If only soles touch,
/// `stop.sunk_link = "ignore"` allows any start.
pub(super) fn below_floor(
    run: &Run,
    model: &Model,
    floor: &Floor,
    start: &Start,
    links: Option<&[LinkHull]>,
) -> Option<Diagnostic> {
    let scenario = &run.scenario;
    let is_ignored = links.is_none() && scenario.stop.sunk_link == SunkLink::Ignore;
    if is_ignored || scenario.robot.backend.is_some() {
        return None;
    }
    let mut state = State::home(model);
    (state.position, state.rotation) = (start.position, start.rotation);
    state.joints.copy_from_slice(&start.joints);
    let mut ws = Workspace::new(model);
    kinematics::update(model, &state, &mut ws);
    let (part, depth) = deepest(run, model, floor, &ws, links)?;

    let depth_text = if depth < 1e-4 { format!("{depth:.1e}") } else { format!("{depth:.4}") };
    let z = start.position.z;
    let message = format!("{part} starts {depth_text} m below the floor, with the base at z = {z} m");
    let up = floor.rotation[(2, 2)];
    let mut help = if up > MIN_TILT_COSINE {
        let height = ((z + depth / up - HEIGHT_ROUNDING) / HEIGHT_STEP).ceil() * HEIGHT_STEP;
        format!("the robot just touches the floor with `base.position` z = {height:.6}")
    } else {
        "start farther from the floor: see `base.position` in `[robot]`".to_owned()
    };
    if links.is_none() {
        help += "; `stop.sunk_link = \"ignore\"` allows this start";
    } else if model.base == Base::Fixed {
        help += "; `floor.plane = false` removes the floor";
    }
    let key = match &scenario.robot {
        robot if robot.base.position.is_some() => "robot.base.position.2",
        robot if !robot.posture.is_empty() => "robot.posture",
        _ if links.is_some() => "robot.contact",
        _ => "robot.model",
    };
    Some(run.error_at(key, message, Some(help)))
}

/// The deepest part that must not start below the floor but does, as text, with its depth, m.
fn deepest(
    run: &Run,
    model: &Model,
    floor: &Floor,
    ws: &Workspace,
    links: Option<&[LinkHull]>,
) -> Option<(String, f64)> {
    let name = |link: LinkId| &model.links[link.0].name;
    let contact = &run.scenario.contact;
    let is_imposed = |sole: &Sole| contact.forced.iter().any(|forced| forced.sole == sole.name && forced.from <= 0.0);
    let sole_depth = |sole: &Sole| {
        let heights = sole.vertices.iter().map(|v| floor.height(&ws.point(sole.link, v)));
        (format!("sole `{}` of link `{}`", sole.name, name(sole.link)), -heights.fold(f64::INFINITY, f64::min))
    };
    let allowed = SOLE_DEPTH.max(contact.distance_tolerance) + LINK_DEPTH;
    let soles = model.soles.iter().filter(|sole| !is_imposed(sole)).map(sole_depth).filter(|(_, d)| *d > allowed);
    let link_text = |link: LinkId, depth: f64| (format!("link `{}`", name(link)), depth);
    let hull_depth = |hull: &LinkHull| {
        let mut lowest = f64::INFINITY;
        hull.heights(ws, floor, 0.0, |_, height| lowest = lowest.min(height));
        link_text(hull.link, -lowest)
    };
    let hulls = links.unwrap_or_default().iter().map(hull_depth).filter(|(_, depth)| *depth > LINK_DEPTH);
    let sunk = if links.is_none() { SunkLinks::new(model).deepest(ws, floor) } else { None };
    let sunk = sunk.map(|(link, depth)| link_text(link, depth));
    soles.chain(hulls).chain(sunk).max_by(|a, b| a.1.total_cmp(&b.1))
}
