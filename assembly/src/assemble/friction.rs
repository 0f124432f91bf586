//! Friction of a scenario as surfaces of the simulation have it.

use crate::scenario::Friction;
use crate::terrain::ExtraFriction;

/// The terms of friction besides the coefficients.
pub(super) fn extra(friction: Friction) -> ExtraFriction {
    let Friction { viscous, torsional, rolling, .. } = friction;
    ExtraFriction { viscous, torsional, rolling }
}
