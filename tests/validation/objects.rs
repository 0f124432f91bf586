//! Balls and boxes on the floor, on terrain and on each other.

use super::case::Case;
use crate::analytic::body::G;
use stiction::scenario::{ForceSpec, ObjectSpec, TerrainSpec};

/// Mass, initial speed and position of the only object.
fn object(case: &Case) -> (f64, f64, [f64; 3]) {
    let [object] = case.run.scenario.object.as_slice() else { panic!("one object") };
    let mass = match object {
        ObjectSpec::Box(body) => body.mass,
        ObjectSpec::Sphere(body) => body.mass,
        other => panic!("a box or a ball, not {other:?}"),
    };
    let entry = object.entry();
    let [x, y, z] = entry.linear_velocity;
    (mass, (x * x + y * y + z * z).sqrt(), entry.position)
}

/// `5/7 g sin tilt` from rest.
pub fn rolls_down(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [roll, tilt, _] = case.run.scenario.floor.rpy;
    assert!(roll == 0.0 && 2.0 / 7.0 * tilt.tan() < case.mu_s());
    let (a, t) = (5.0 / 7.0 * G * tilt.sin(), case.duration());
    match metric {
        "final_object_shift_m" => Some(a * t * t / 2.0),
        "final_object_speed_m_per_s" => Some(a * t),
        "friction_loss_J" => Some(0.0),
        _ => None,
    }
}

/// Slides until `2 v / (7 mu g)`, then rolls with `5/7 v`.
pub fn begins_to_roll(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (mass, v, _) = object(case);
    let (mu, end) = (case.mu_k(), case.duration());
    let t = 2.0 * v / (7.0 * mu * G);
    assert!(t < end);
    match metric {
        "first_stick_s" => Some(t),
        "final_object_shift_m" => Some(v * t - mu * G * t * t / 2.0 + 5.0 / 7.0 * v * (end - t)),
        "final_object_speed_m_per_s" => Some(5.0 / 7.0 * v),
        "friction_loss_J" => Some(mass * v * v / 7.0),
        _ => None,
    }
}

/// Tips when its centre has reached the edge of the table.
pub fn over_edge(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [TerrainSpec::Box(table)] = case.run.scenario.terrain.as_slice() else { panic!("one table") };
    let (_, v, position) = object(case);
    assert_eq!(case.mu_k(), 0.0);
    (metric == "first_tip_s").then(|| (table.position[0] + table.size[0] / 2.0 - position[0]) / v)
}

/// Stops after `v^2 / (2 mu g)`, at `v / (mu g)`, on pieces whose upper faces are level and adjoin.
pub fn over_seams(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let pieces = case.run.scenario.terrain.iter().map(|piece| match piece {
        TerrainSpec::Box(piece) => (piece.position, piece.size),
        other => panic!("boxes, not {other:?}"),
    });
    let pieces: Vec<_> = pieces.collect();
    assert!(pieces.iter().all(|(p, size)| (p[2] + size[2] / 2.0 - 0.25).abs() < 1e-15));
    assert!(pieces.windows(2).all(|w| (w[0].0[0] + w[0].1[0] / 2.0 - w[1].0[0] + w[1].1[0] / 2.0).abs() < 1e-15));
    let (_, v, _) = object(case);
    let mu = case.mu_k();
    match metric {
        "final_object_shift_m" => Some(v * v / (2.0 * mu * G)),
        "first_stick_s" => Some(v / (mu * G)),
        _ => None,
    }
}

/// A push that grows by k slips the block at `mu m g / k`, then `m x'' = k t - mu m g`.
pub fn slips_on_box(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [ForceSpec::Ramp(push)] = case.run.scenario.force.as_slice() else { panic!("one ramp") };
    let mu = case.run.scenario.object[0].entry().friction.expect("friction of its own").kinetic;
    let (mass, _, _) = object(case);
    assert!(mu * case.weight() < mu.min(case.mu_s()) * (case.weight() + mass * G));
    let rate = push.force[0] / push.duration;
    let slips = mu * case.weight() / rate;
    match metric {
        "first_slip_s" => Some(slips),
        "final_base_shift_m" => Some(rate * (case.duration() - slips).powi(3) / (6.0 * case.mass())),
        "final_object_shift_m" => Some(0.0),
        _ => None,
    }
}

/// A push that grows by k slips block and box at `mu (m + M) g / k`, then `(m + M) x'' = k t - mu (m + M) g`.
pub fn slip_in_line(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [ForceSpec::Ramp(push)] = case.run.scenario.force.as_slice() else { panic!("one ramp") };
    let (mass, _, [x, y, z]) = object(case);
    let ObjectSpec::Box(body) = &case.run.scenario.object[0] else { panic!("a box") };
    let half = case.half();
    assert!(x - half[0] - body.size[0] / 2.0 == 0.0 && y == 0.0 && z == body.size[2] / 2.0, "they touch, in line");
    let (sum, rate) = (case.mass() + mass, push.force[0] / push.duration);
    let slips = case.mu_s() * sum * G / rate;
    match metric {
        "first_slip_s" => Some(slips),
        "final_base_shift_m" | "final_object_shift_m" => Some(rate * (case.duration() - slips).powi(3) / (6.0 * sum)),
        _ => None,
    }
}
