//! States moved onto their couplings and loops.
//!
//! Newton's method, each time by the least displacement that removes the errors to first order, weighted
//! by the mass matrix; then the least such change of the velocities, `G v = 0`. Held or prescribed
//! velocities do not take part.

use super::DynamicsError;
use super::constraints::{Scratch, greatest, norm};
use super::state::State;
use super::workspace::Workspace;
use super::{crba, factor, kinematics};
use crate::robot::Model;

/// Error of a condition that rounding leaves, m or rad.
const CLOSED: f64 = 1e-14;
/// Greatest number of corrections after a step: two suffice for its errors.
const MOST_AFTER_STEP: usize = 4;
/// The same from any state, the longest of them, rad or m, and the part of one below which none helps.
const MOST_CORRECTIONS: usize = 200;
const LONGEST: f64 = 0.3;
const SHORTEST_PART: f64 = 1e-6;

/// Errors that [`close`] leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closed {
    /// Greatest error of a condition, m or rad.
    pub position: f64,
    /// Greatest rate of one, m/s or rad/s.
    pub velocity: f64,
}

/// Removes the errors that integration has left in `state`, near its conditions. The workspace then
/// belongs to the new state, except for bias and factor. Does not allocate.
///
/// # Errors
/// A mass matrix that cannot be factorised.
pub fn project(
    model: &Model,
    state: &mut State,
    prescribed: &[usize],
    ws: &mut Workspace,
) -> Result<(), DynamicsError> {
    let mut scratch = std::mem::take(&mut ws.constraints.scratch);
    let result = project_with(model, state, prescribed, ws, &mut scratch);
    ws.constraints.scratch = scratch;
    result
}

fn project_with(
    model: &Model,
    state: &mut State,
    prescribed: &[usize],
    ws: &mut Workspace,
    scratch: &mut Scratch,
) -> Result<(), DynamicsError> {
    let mut last = f64::INFINITY;
    for i in 0..=MOST_AFTER_STEP {
        kinematics::update(model, state, ws);
        let error = ws.constraints.greatest_error();
        // Corrections of rounding do not reduce it.
        if error <= CLOSED || !(error < 0.5 * last) || i == MOST_AFTER_STEP {
            break;
        }
        last = error;
        find_displacement(model, prescribed, ws, scratch)?;
        state.displace(&scratch.x);
    }
    project_velocities(model, state, prescribed, ws, scratch)
}

/// Displacement that removes the present errors to first order, in `scratch.x`.
fn find_displacement(
    model: &Model,
    held: &[usize],
    ws: &mut Workspace,
    scratch: &mut Scratch,
) -> Result<(), DynamicsError> {
    crba::mass_matrix(model, ws);
    factor::factorize_prescribed(ws, &[], held)?;
    ws.constraints.correction(&ws.constraints.error, &mut scratch.d, &mut scratch.x);
    factor::solve_l(&ws.factor, &mut scratch.x);
    Ok(())
}

fn project_velocities(
    model: &Model,
    state: &mut State,
    held: &[usize],
    ws: &mut Workspace,
    scratch: &mut Scratch,
) -> Result<(), DynamicsError> {
    crba::mass_matrix(model, ws);
    factor::factorize_prescribed(ws, &[], held)?;
    ws.constraints.rates(&state.v, &mut scratch.rates);
    ws.constraints.correction(&scratch.rates, &mut scratch.d, &mut scratch.x);
    factor::solve_l(&ws.factor, &mut scratch.x);
    state.v.iter_mut().zip(&scratch.x).for_each(|(v, x)| *v += x);
    kinematics::update(model, state, ws);
    Ok(())
}

/// As [`project`] from any state, in shortened corrections, where the velocities `held` and the
/// displacements along them stay as they are. Returns the errors left. Allocates.
///
/// # Errors
/// A mass matrix that cannot be factorised.
pub fn close(model: &Model, state: &mut State, held: &[usize], ws: &mut Workspace) -> Result<Closed, DynamicsError> {
    let mut scratch = ws.constraints.scratch.clone();
    let mut start = state.clone();
    kinematics::update(model, state, ws);
    let (mut error, mut length) = (ws.constraints.greatest_error(), norm(&ws.constraints.error));
    'corrections: for _ in 0..MOST_CORRECTIONS {
        if error <= CLOSED {
            break;
        }
        find_displacement(model, held, ws, &mut scratch)?;
        start.copy_from(state);
        let mut part = (LONGEST / greatest(&scratch.x)).min(1.0);
        scratch.x.iter_mut().for_each(|x| *x *= part);
        loop {
            state.displace(&scratch.x);
            kinematics::update(model, state, ws);
            let next = norm(&ws.constraints.error);
            if next < length {
                (error, length) = (ws.constraints.greatest_error(), next);
                break;
            }
            state.copy_from(&start);
            part *= 0.5;
            scratch.x.iter_mut().for_each(|x| *x *= 0.5);
            if !(part > SHORTEST_PART) {
                break 'corrections;
            }
        }
    }
    kinematics::update(model, state, ws);
    project_velocities(model, state, held, ws, &mut scratch)?;
    ws.constraints.rates(&state.v, &mut scratch.rates);
    Ok(Closed { position: error, velocity: greatest(&scratch.rates) })
}
