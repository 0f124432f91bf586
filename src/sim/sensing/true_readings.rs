//! Exact readings of the plant.

use crate::sim::plant::Plant;
use crate::task::SensorReadings;
use nalgebra::Vector3;

/// Reads the plant's state and last evaluation without errors, except the IMU. The loads of the
/// soles are read only with `loads`. `since` is the time of the last reading, s.
pub(super) fn read(plant: &mut Plant, loads: bool, since: Option<f64>, out: &mut SensorReadings) {
    let state = &plant.state;
    let nb = plant.model.nb();
    out.position.copy_from_slice(&state.joints);
    out.velocity.copy_from_slice(&state.v[nb..]);
    out.load.copy_from_slice(&plant.drives.efforts);
    if !loads {
        return;
    }
    plant.share_forces();
    let span = since.map(|t| plant.state.time - t).filter(|span| *span > 0.0);
    let floor = &plant.floor.rotation;
    for (s, sole) in out.soles.iter_mut().enumerate() {
        let w = &plant.solution.wrench[6 * s..6 * s + 6];
        sole.force = floor * Vector3::new(w[0], w[1], w[2]);
        sole.moment = floor * Vector3::new(w[3], w[4], w[5]);
        let impulse = plant.impulses.as_mut().map(|impulses| floor * impulses.take(s));
        sole.mean_force = impulse.zip(span).map_or(sole.force, |(impulse, span)| impulse / span);
        sole.resolved = true;
        let k = sole.vertices.len();
        for i in 0..k {
            let (n, t) = (plant.solution.normal[s][i], plant.solution.tangent[s][i]);
            sole.vertices[i] = floor * Vector3::new(t.x, t.y, n);
            sole.clamped[i] = plant.states[s].clamps(i, k);
        }
    }
}
