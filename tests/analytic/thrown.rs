//! Bodies thrown at each other: without a closed form, but with conditions that hold at all times.

use crate::support::runs::{finish, simulation};
use stiction::sim::NullObserver;

/// A vertex that becomes a pivot out of a slow slip is brought to rest. It was left moving at 0.1 m/s where only
/// the normal velocities counted as the error that is removed.
#[test]
fn pivots_of_thrown_bodies_are_at_rest() {
    let mut sim = simulation(include_str!("thrown.toml"));
    let m = finish(&mut sim, &mut NullObserver);
    // The error of steps at the default tolerance of the integrator.
    assert!(m.max_creep_speed_m_per_s < 1e-6 && m.energy_error_j.abs() < 1e-6, "{m:?}");
    assert!(m.inconsistent == 0 && m.max_cone_excess < 1e-9 && m.max_penetration_m < 1e-9, "{m:?}");
}
