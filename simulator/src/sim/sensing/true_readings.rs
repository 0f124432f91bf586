//! Exact readings of the plant.

use crate::sim::plant::Plant;
use crate::sim::plant::sole_loads::SoleContact;
use crate::task::SensorReadings;
use crate::task::sensor_readings::{SoleCorner, SoleLoad};
use nalgebra::Vector3;

/// Distance, m, up to which a corner of a contact is a vertex of the sole.
const SAME_POINT: f64 = 1e-9;

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
        sole.resolved = true;
        let k = sole.vertices.len();
        for i in 0..k {
            let (n, t) = (plant.solution.normal[s][i], plant.solution.tangent[s][i]);
            sole.vertices[i] = floor * Vector3::new(t.x, t.y, n);
            sole.clamped[i] = plant.states[s].clamps(i, k);
        }
        sole.corners.clear();
    }
    for contact in plant.sole_contacts() {
        add_contact(plant, &contact, &mut out.soles[contact.sole]);
    }
    for (s, sole) in out.soles.iter_mut().enumerate() {
        let impulse = plant.impulses.as_mut().map(|impulses| plant.floor.rotation * impulses.take(s));
        sole.mean_force = impulse.zip(span).map_or(sole.force, |(impulse, span)| impulse / span);
    }
}

/// Adds a contact of a sole's link to its load.
fn add_contact(plant: &Plant, contact: &SoleContact, out: &mut SoleLoad) {
    let &SoleContact { sole, polygon, sign } = contact;
    let (force, moment) = plant.polygon_load(polygon);
    let (axes, reference) = (&plant.reduced.axes[polygon], plant.reduced.reference[polygon]);
    let arm = reference - plant.reduced.reference[sole];
    out.force += force * sign;
    out.moment += (moment + arm.cross(&force)) * sign;
    let vertices = &plant.problem.soles[polygon].vertices;
    let sole = &plant.model.soles[sole];
    for (i, vertex) in vertices.iter().enumerate() {
        let (n, t) = (plant.solution.normal[polygon][i], plant.solution.tangent[polygon][i]);
        let force = axes * Vector3::new(t.x, t.y, n) * sign;
        if !plant.states[polygon].clamps(i, vertices.len()) {
            continue;
        }
        let position = reference + axes * vertex.r;
        let is_at = |local: &Vector3<f64>| (plant.ws.point(sole.link, local) - position).norm() < SAME_POINT;
        match sole.vertices.iter().position(is_at) {
            Some(k) => {
                out.vertices[k] += force;
                out.clamped[k] = true;
            }
            None => out.corners.push(SoleCorner { position, force }),
        }
    }
}
