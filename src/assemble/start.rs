//! The initial state of the robot.

use crate::assemble::MIN_TILT_COSINE;
use crate::assemble::names::{check_range, joints};
use crate::dynamics::{State, Workspace, kinematics};
use crate::robot::{Base, Model};
use crate::scenario::{Diagnostic, Run};
use crate::sim::Floor;
use crate::sim::setup::Start;
use nalgebra::{UnitQuaternion, Vector3};

/// Initial state. Without a base position the robot stands above the world's origin, its lowest
/// sole vertex on the floor.
pub(super) fn start(run: &Run, model: &Model, floor: &Floor, errors: &mut Vec<Diagnostic>) -> Start {
    let spec = &run.scenario.robot;
    let mut state = State::home(model);
    for (id, q) in joints(model, run, "robot.posture", spec.posture.iter(), errors) {
        let key = format!("robot.posture.{}", model.joints[id.0].name);
        check_range(run, model, &key, id, ("the initial posture", q, q), errors);
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
        None if floor.rotation[(2, 2)].abs() < MIN_TILT_COSINE => {
            let message = "the robot cannot start above this floor, which is vertical: see `floor.rpy`";
            let help = "give `base.position` in `[robot]`".to_owned();
            errors.push(run.error_at("floor.rpy", message, Some(help)));
            Vector3::zeros()
        }
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
