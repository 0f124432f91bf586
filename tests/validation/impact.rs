//! Boxes that fall flat, with and without restitution.

use super::case::Case;
use crate::analytic::body::G;

/// `t = sqrt(2 h / g)`, `m g h` lost, at rest on the floor.
pub fn landing(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let height = case.fall();
    match metric {
        "first_touchdown_s" => Some((2.0 * height / G).sqrt()),
        "impact_loss_J" => Some(case.weight() * height),
        "final_base_z" => Some(case.half()[2]),
        "impacts" => Some(1.0),
        "first_impact_speed_ratio" => Some(0.0),
        _ => None,
    }
}

/// The run ends at the top of a bounce, `e^(2 n) h` high.
pub fn heights(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (height, e) = (case.fall(), case.run.scenario.contact.restitution);
    let fall = (2.0 * height / G).sqrt();
    // Up from the first impact for e t, down and up again ..
    let (mut top, mut n) = (fall * (1.0 + e), 1);
    while top < case.duration() - 1e-9 {
        top += fall * (e.powi(n) + e.powi(n + 1));
        n += 1;
    }
    assert!((top - case.duration()).abs() < 1e-14, "at a top: {top}");
    match metric {
        "final_base_z" => Some(case.half()[2] + e.powi(2 * n) * height),
        "impacts" => Some(f64::from(n)),
        "first_impact_speed_ratio" => Some(e),
        _ => None,
    }
}

/// `sqrt(2 h / g) (1 + e) / (1 - e)`, minus the contribution of rebounds slower than
/// `velocity_tolerance`.
pub fn rest(case: &Case, index: usize, metric: &str) -> Option<f64> {
    let (height, contact) = (case.fall(), &case.run.scenario.contact);
    let (e, fall) = (contact.restitution, (2.0 * height / G).sqrt());
    let ideal = fall * (1.0 + e) / (1.0 - e);
    let (mut last, mut rebounds, mut speed) = (fall, 0, G * fall * e);
    while speed > contact.velocity_tolerance {
        last += 2.0 * speed / G;
        rebounds += 1;
        speed *= e;
    }
    // The omitted series begins with the first rebound below the tolerance.
    assert!((ideal - last - 2.0 * speed / (G * (1.0 - e))).abs() < 1e-14);
    match (metric, index) {
        ("last_impact_s", 0) => Some(last),
        ("last_impact_s", _) => {
            let limit = 2.0 * contact.velocity_tolerance / (G * (1.0 - e));
            let tolerance = case.run.scenario.expect[index].tolerance.expect("it is given");
            assert!((tolerance / limit - 1.0).abs() < 0.01, "{tolerance} {limit}");
            Some(ideal)
        }
        ("final_base_z", _) => Some(case.half()[2]),
        ("impacts", _) => Some(f64::from(rebounds + 1)),
        _ => None,
    }
}
