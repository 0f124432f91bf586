//! Start postures of mechanisms with couplings and closed loops: following joints at the positions of their
//! leaders, loops closed.
//!
//! The base and joints that the scenario gives stay as they are. Joints without a drive move first; if
//! these cannot close the loops, the others too.

use crate::dynamics::{State, Workspace, closing};
use crate::robot::{DriveMode, JointId, Model};
use crate::scenario::{Diagnostic, Run};

/// Greatest error of a loop at the start, m or rad, and of its rate, m/s or rad/s.
const CLOSED: f64 = 1e-12;
const CLOSED_RATE: f64 = 1e-9;

/// Keys of the scenario that give a mechanism's joints.
pub(super) struct Given<'a> {
    /// The posture of all other joints: that of a keyframe, or home.
    pub base: &'a [f64],
    /// Joints with a position, and its key.
    pub posture: &'a [(JointId, f64)],
    pub posture_key: &'a str,
    /// Joints with a velocity, and its key.
    pub velocity: &'a [(JointId, f64)],
    pub velocity_key: &'a str,
    /// Key of the model.
    pub model_key: &'a str,
}

/// Parts in which joints are moved from home or the keyframe to the posture given, closing the loops each time:
/// these stay assembled as they are there.
const PARTS: u32 = 64;

/// Moves `state` onto the couplings and loops of its model; what cannot be is an error.
pub(super) fn close(run: &Run, model: &Model, given: &Given, state: &mut State, errors: &mut Vec<Diagnostic>) {
    if model.couplings.is_empty() && model.loops.is_empty() {
        return;
    }
    let nb = model.nb();
    set_followers(model, given, state);
    let mut ws = Workspace::new(model);
    let velocities = state.v.clone();
    let is_given = |j: usize| given.posture.iter().any(|(id, _)| id.0 == j);
    let held = |holds: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..nb).chain((0..model.nj()).filter(|j| holds(*j)).map(|j| nb + j)).collect()
    };
    let has_drive = |j: usize| model.joints[j].drive.mode != DriveMode::Passive;
    let start = state.clone();
    let mut error = f64::INFINITY;
    for held in [held(&|j| is_given(j) || has_drive(j)), held(&is_given)] {
        state.joints.copy_from_slice(given.base);
        for part in 1..=PARTS {
            let part = f64::from(part) / f64::from(PARTS);
            for &(JointId(j), q) in given.posture {
                state.joints[j] = if part == 1.0 { q } else { given.base[j] + part * (q - given.base[j]) };
            }
            error = closing::close(model, state, &held, &mut ws).map_or(f64::INFINITY, |closed| closed.position);
        }
        if error <= CLOSED {
            break;
        }
        state.copy_from(&start);
    }
    if !(error <= CLOSED) {
        let part = worst(model, &ws);
        let message = format!("{part} cannot be closed at the start: an error of {error:.3e} m or rad is left");
        let key = if given.posture.is_empty() { given.model_key } else { given.posture_key };
        let help = "leave joints out of `posture` that may move to close it, or give a posture nearer to a closed one";
        errors.push(run.error_at(key, message, Some(help.to_owned())));
        return;
    }
    state.v.copy_from_slice(&velocities);
    let moves = |j: usize| given.velocity.iter().any(|(id, _)| id.0 == j);
    let rate = closing::close(model, state, &held(&moves), &mut ws).map_or(f64::INFINITY, |closed| closed.velocity);
    if !(rate <= CLOSED_RATE) {
        let message = format!(
            "{} cannot move at the velocities given: a rate of {rate:.3e} m/s or rad/s is left",
            worst(model, &ws)
        );
        let key = if given.velocity.is_empty() { given.model_key } else { given.velocity_key };
        let help = "leave joints out of `velocity`: those that follow get their own".to_owned();
        errors.push(run.error_at(key, message, Some(help)));
    }
}

/// Sets following joints whose positions and velocities the scenario does not give.
fn set_followers(model: &Model, given: &Given, state: &mut State) {
    let nb = model.nb();
    let has = |list: &[(JointId, f64)], joint: JointId| list.iter().any(|(id, _)| *id == joint);
    for coupling in &model.couplings {
        let (position, slope, _) = coupling.evaluate(state.joints[coupling.leader.0]);
        if !has(given.posture, coupling.joint) {
            state.joints[coupling.joint.0] = position;
        }
        if !has(given.velocity, coupling.joint) {
            state.v[nb + coupling.joint.0] = slope * state.v[nb + coupling.leader.0];
        }
    }
}

/// Name of the coupling or loop with the greatest error at the kinematics in the workspace.
fn worst(model: &Model, ws: &Workspace) -> String {
    let errors = &ws.constraints.error;
    let of_couplings = model.couplings.iter().enumerate().map(|(i, coupling)| {
        let (joint, leader) = (&model.joints[coupling.joint.0].name, &model.joints[coupling.leader.0].name);
        (errors[i].abs(), format!("the coupling of joint `{joint}` to `{leader}`"))
    });
    let of_loops = model
        .loop_conditions()
        .map(|(closure, rows)| (ws.constraints.greatest_error_of(rows), format!("the loop `{}`", closure.name)));
    of_couplings.chain(of_loops).max_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(String::new, |(_, name)| name)
}
