//! Rigid-body dynamics of a tree: `M(q) vdot + h(q, v) = tau`.
//!
//! **One common frame.** All spatial quantities are in world axes about one fixed point O, the
//! current position of the base (the root of a fixed base). Twists, wrenches and inertias of
//! all links then add without 6-D transforms, and each joint axis needs one cross product. O is an
//! inertial point: it does not move with the base.
//!
//! - Stacking: linear first, then angular. A wrench is (force, moment about O).
//! - `v = [p' (world), omega (world), joint rates]`, `vdot = [p'', omega', joint accelerations]`; a
//!   fixed base has the joint part only. The spatial acceleration of the base about O is
//!   `(p'' - omega x p', omega')`.
//! - Generalised forces `tau` are dual to `v`: base force, base moment about the base origin, joint
//!   efforts.
//!
//! Algorithms are functions of ([`Model`], [`State`], [`Workspace`]); none of them allocates. The
//! usual order per evaluation is [`prepare`], then [`reduced::assemble`] or [`factor::solve`].
//!
//! Source of the algorithms: [Featherstone 2008], chapters 5 to 8.
//!
//! Imports: `math`, `robot`. Used by: `task`, `force`, `script`, `sim`, `assemble`, `remote`,
//! `console`.

pub mod aba;
pub mod body;
pub mod chain;
pub mod closing;
pub mod conditions;
pub mod constraints;
pub mod crba;
pub mod factor;
pub mod jacobian;
pub mod kinematics;
pub mod link_force;
pub mod reduced;
pub mod rnea;
pub mod spatial;
pub mod state;
pub mod tree_matrix;
pub mod workspace;

pub use constraints::Constraints;
pub use reduced::Reduced;
pub use spatial::{Force, Inertia, Motion};
pub use state::State;
pub use tree_matrix::TreeMatrix;
pub use workspace::{LinkMotion, Workspace};

use crate::robot::Model;
use nalgebra::Vector3;

/// Error of the dynamics algorithms.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum DynamicsError {
    /// The mass matrix is not positive definite: a joint moves no inertia, or the state is not
    /// finite.
    #[error("the mass matrix is singular at velocity {dof} (pivot {pivot:e}): it moves no mass, inertia or armature")]
    Singular {
        /// Index into `v`.
        dof: usize,
        /// Its pivot, kg or kg m^2.
        pivot: f64,
    },
}

/// Evaluates the equation of motion at one state into `ws`: kinematics, bias `h`, mass matrix `M`
/// and its factor. `gravity` in m/s^2, world axes.
///
/// # Errors
/// [`DynamicsError::Singular`] when `M` cannot be factorised.
pub fn prepare(model: &Model, state: &State, gravity: &Vector3<f64>, ws: &mut Workspace) -> Result<(), DynamicsError> {
    kinematics::update(model, state, ws);
    rnea::bias(ws, gravity);
    crba::mass_matrix(model, ws);
    factor::factorize(ws)
}
