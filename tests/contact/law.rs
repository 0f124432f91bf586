//! Checks the contact laws on a solution from its vertex forces, independently of selection and
//! validation.

use nalgebra::{Vector2, Vector3};
use stiction::contact::model::friction_capacity;
use stiction::contact::model::problem::Problem;
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::States;

/// Describes each violation; empty if all laws hold. Applies at the acceleration level from rest,
/// at the velocity level after a plastic impulse. `drive` is the size of the motion without
/// contact, the scale of small motions.
pub fn violations(p: &Problem, states: &States, out: &Solution, drive: f64) -> Vec<String> {
    let mut list = vec![];
    let mut bar = |what: String, value: f64, limit: f64| {
        if !(value <= limit) {
            list.push(format!("{what}: {value:.3e} > {limit:.1e}"));
        }
    };
    let load = p.scale;
    // The solution satisfies m = b + W w up to rounding of 12 products times the condition of the
    // joint.
    let n = p.dim();
    for r in 0..n {
        let m: f64 = p.b[r] + (0..n).map(|c| p.w[n * r + c] * out.wrench[c]).sum::<f64>();
        bar(format!("m = b + W w, row {r}"), (m - out.motion[r]).abs(), 1e-10 * drive);
    }
    for (s, sole) in p.soles.iter().enumerate() {
        let (state, k) = (states[s], sole.vertices.len());
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (i, v) in sole.vertices.iter().enumerate() {
            let f = Vector3::new(out.tangent[s][i].x, out.tangent[s][i].y, out.normal[s][i]);
            force += f;
            moment += v.r.cross(&f);
            let m = p.vertex_motion(&out.motion, s, i);
            let target = sole.vertex_target(i);
            bar(format!("{s}/{i} pulls"), -f.z, 1e-9 * load);
            // The tolerance is 1e-8 m/s^2, or 1e-10 at the velocity level.
            bar(format!("{s}/{i} enters"), target - m.z, 1.01e-8 + 1e-9 * drive);
            if !state.clamps(i, k) {
                bar(format!("{s}/{i} is loaded though free"), f.norm(), 0.0);
                continue;
            }
            bar(format!("{s}/{i} leaves though clamped"), m.z - target, 1e-9 * drive);
            if state.is_static() {
                bar(format!("{s}/{i} moves though it sticks"), m.xy().norm(), 1e-9 * drive);
                continue;
            }
            // Inside the friction cone; slip is opposed with full kinetic friction, directions
            // found to 1e-10.
            bar(format!("{s}/{i} cone"), f.xy().norm() - v.mu_s * f.z.max(0.0), 1e-9 * load);
            if m.xy().norm() > 1e-7 * drive {
                let gap = (f.xy() + m.xy().normalize() * (v.mu_k * f.z)).norm();
                bar(format!("{s}/{i} not opposed"), gap, 1e-2 * load * 1e-7 * drive / m.xy().norm() + 1e-9 * load);
            }
        }
        let w = &out.wrench[6 * s..6 * s + 6];
        let wrench = (Vector3::new(w[0], w[1], w[2]), Vector3::new(w[3], w[4], w[5]));
        // This also shows load that friction at a static vertex or edge does not carry.
        let lost = (force - wrench.0).norm() + (moment - wrench.1).norm() / sole.radius;
        bar(format!("{s} forces and wrench differ"), lost, 1e-9 * load);
    }
    for s in (0..p.soles.len()).filter(|&s| states[s].is_static()) {
        // Static soles of one body can only slip together.
        let group: Vec<_> =
            (0..p.soles.len()).filter(|&t| states[t].is_static() && p.soles[t].body == p.soles[s].body).collect();
        let mut points = vec![];
        let (mut force, mut yaw) = (Vector2::zeros(), 0.0);
        for &t in &group {
            for (i, v) in p.soles[t].vertices.iter().enumerate() {
                let (place, f) = ((p.soles[t].position + v.r).xy(), out.tangent[t][i]);
                points.push((v.mu_s * out.normal[t][i].max(0.0), place));
                force += f;
                yaw += place.perp(&f);
            }
        }
        let loaded = points.iter().filter(|(c, _)| *c > 0.0).count();
        let left = if loaded > 1 {
            friction_capacity::face(&points, &force, yaw, 0.1).0
        } else {
            points.iter().map(|(c, _)| *c).sum::<f64>() - force.norm()
        };
        bar(format!("{s} capacity"), -left, 1e-9 * load);
    }
    list
}
