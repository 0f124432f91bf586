//! Neural networks as tasks: observations of the robot to a network, its output to joint commands.
//!
//! The network is an ONNX file, evaluated in single precision by the crate `tract-onnx`. Only the
//! file `onnx.rs`, behind the cargo feature `policy`, depends on that crate; without the feature
//! [`load`] returns the error that names it.
//!
//! Imports: `math`, `files`, `robot`, `task`. Used by: `assemble`.

mod history;
mod network;
mod observation;
#[cfg(feature = "policy")]
mod onnx;
mod policy_task;

pub use history::History;
pub use network::{Interface, LoadError, Network, Part, load};
pub use observation::{Quantity, Term};
pub use policy_task::{Action, ActionMode, Policy, Settings};
