//! Sole forces as a force-torque sensor tells them.

use crate::task::sensed::SoleLoad;
use nalgebra::Vector3;

/// A part of what a sole's sensor reads.
pub(super) type Part = fn(&mut SoleLoad) -> &mut Vector3<f64>;

/// The force.
pub(super) fn force(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.force
}

/// The moment.
pub(super) fn moment(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.moment
}
