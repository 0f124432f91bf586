//! Extrapolates joint positions under constant accelerations.
//!
//! ```text
//! q'(s) = clamp(q' + q'' s, -v_max, v_max),   q(t) = clamp(q + integral of q'(s) ds from 0 to t, lower, upper)
//! ```
//!
//! Without limits this is `q + q' t + q'' t^2 / 2`. The limits of speed and range keep predictions
//! within the robot's abilities ([Hale 2008], section IV, "kinematics"). The clamped speed is a
//! ramp between two constants, so its integral is exact.

use crate::robot::Model;

/// Joint positions (rad, m) after `t` s, from positions `q`, velocities `qd` and constant
/// accelerations `qdd`. Speeds are clamped to the joints' limits throughout, positions to their
/// ranges at the end.
///
/// # Panics
/// When a slice is shorter than the model's joints.
pub fn extrapolate(model: &Model, q: &[f64], qd: &[f64], qdd: &[f64], t: f64, out: &mut [f64]) {
    for (i, joint) in model.joints.iter().enumerate() {
        let travel = capped_travel(qd[i], qdd[i], joint.velocity_limit, t);
        out[i] = (q[i] + travel).clamp(joint.lower, joint.upper);
    }
}

/// Integral of the clamped speed.
pub(crate) fn capped_travel(v: f64, a: f64, limit: f64, t: f64) -> f64 {
    if a == 0.0 || !limit.is_finite() {
        return (v.clamp(-limit, limit)) * t + a * t * t / 2.0;
    }
    // Times at which the ramp enters and leaves the allowed speeds.
    let enters = ((-limit * a.signum() - v) / a).clamp(0.0, t);
    let leaves = ((limit * a.signum() - v) / a).clamp(0.0, t);
    let ramp = leaves - enters;
    let start = (v + a * enters).clamp(-limit, limit);
    limit * a.signum() * ((t - leaves) - enters) + start * ramp + a * ramp * ramp / 2.0
}

#[cfg(test)]
mod tests {
    use super::capped_travel;

    #[test]
    fn without_limits_extrapolation_is_a_parabola() {
        // One rounding of each of three terms.
        for (v, a, t) in [(0.5, -2.0, 0.7), (0.0, 3.0, 0.1), (-1.0, 0.0, 2.0)] {
            for limit in [f64::INFINITY, 1e3] {
                let expected = v * t + a * t * t / 2.0;
                assert!((capped_travel(v, a, limit, t) - expected).abs() < 1e-15, "{v} {a} {t} {limit}");
            }
        }
    }

    #[test]
    fn limits_clip_the_ramp_at_both_ends() {
        // From 0 at 2/s^2 the cap of 1 is reached after 0.5 s and 0.25 covered; then 1 per second.
        assert_eq!(capped_travel(0.0, 2.0, 1.0, 2.0), 0.25 + 1.5);
        // From -3, clamped to -1: 1 down until the ramp passes -1 at 1 s, nothing until +1 at 2 s,
        // then 1 up.
        assert_eq!(capped_travel(-3.0, 2.0, 1.0, 3.0), -1.0 + 0.0 + 1.0);
        assert_eq!(capped_travel(3.0, -2.0, 1.0, 3.0), 1.0 + 0.0 - 1.0);
        // Starts above the limit and accelerates further: the limit throughout.
        assert_eq!(capped_travel(5.0, 1.0, 2.0, 0.5), 1.0);
        assert_eq!(capped_travel(5.0, 0.0, 2.0, 0.5), 1.0);
        assert_eq!(capped_travel(-5.0, -1.0, 2.0, 0.5), -1.0);
    }

    #[test]
    fn travel_is_the_integral_of_the_clamped_speed() {
        let mut r = crate::random::Stream::new(3, &["extrapolate"]);
        for _ in 0..1000 {
            let (v, a, limit, t) = (4.0 * r.normal(), 8.0 * r.normal(), 3.0 * r.unit(), 2.0 * r.unit());
            let n = 20_000;
            let step = t / f64::from(n);
            let speed = |i: i32| (v + a * step * (f64::from(i) + 0.5)).clamp(-limit, limit);
            let sum: f64 = (0..n).map(speed).sum::<f64>() * step;
            // The midpoint rule is exact on straight parts and errs by at most a h^2 / 8 at each of
            // the two kinks.
            let bar = a.abs() * step * step / 4.0 + 1e-12;
            assert!((capped_travel(v, a, limit, t) - sum).abs() <= bar, "{v} {a} {limit} {t}");
        }
    }
}
