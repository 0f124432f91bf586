//! Mounting of the inertial measurement unit.

use crate::dynamics::State;
use crate::dynamics::chain::{self, FrameMotion};
use crate::robot::{Model, Mount};
use nalgebra::UnitQuaternion;

/// The unit's mounting: on a link, or (the default) at the base's origin, in the base's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Imu(pub Option<Mount>);

impl Imu {
    /// Its motion at `state`.
    pub fn motion(&self, model: &Model, state: &State) -> FrameMotion {
        let base = FrameMotion::of_base(state);
        match &self.0 {
            None => base,
            Some(mount) => chain::from_root(model, mount, &state.joints, state.rates()).carried_by(&base),
        }
    }

    /// Orientation of the base when the unit has the orientation `frame`.
    pub fn base_orientation(
        &self,
        model: &Model,
        frame: &UnitQuaternion<f64>,
        q: &[f64],
        qd: &[f64],
    ) -> UnitQuaternion<f64> {
        match &self.0 {
            None => *frame,
            Some(mount) => frame * chain::from_root(model, mount, q, qd).rotation.inverse(),
        }
    }

    /// Motion of the base from that of the unit, `frame`, and the joints of `state`; the base of
    /// `state` is not used.
    pub fn base(&self, model: &Model, state: &State, frame: &FrameMotion) -> FrameMotion {
        match &self.0 {
            None => *frame,
            Some(mount) => chain::from_root(model, mount, &state.joints, state.rates()).carries(frame),
        }
    }
}
