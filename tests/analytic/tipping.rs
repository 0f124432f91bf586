//! A body pushed high tips; one pushed low slides; one that slides fast does not hop.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, rk4, run, watch};

/// A push along the body's x axis, growing from 0 to `full` over `time`, `height` above the floor.
fn push(body: &Body, yaw: f64, mu: f64, height: f64, full: f64, time: f64, duration: f64) -> String {
    format!(
        "duration = {duration}\nfloor = {{ friction = {mu} }}\n{}{TIGHT}
        [[force]]
        type = \"push\"
        link = \"block\"
        point = [0.0, 0.0, {}]
        force = [{}, {}, 0.0]
        duration = {time}
        profile = \"ramp\"\n",
        body.robot(&format!("rpy = [0.0, 0.0, {yaw}]")),
        height - body.half[2],
        full * yaw.cos(),
        full * yaw.sin()
    )
}

#[test]
fn a_box_slides_first_below_b_over_h_and_tips_first_above() {
    for half in [[0.1, 0.1, 0.1], [0.05, 0.08, 0.1], [0.02, 0.03, 0.06]] {
        let body = Body::new(half, 1.3);
        for (k, height) in [0.6, 1.0, 1.5].into_iter().map(|f| f * half[2]).enumerate() {
            let limit = half[0] / height;
            for mu in [0.7 * limit, 0.99 * limit, 1.01 * limit, 1.4 * limit] {
                let yaw = 0.3 + 0.9 * k as f64;
                let truth = body.mass * G * mu.min(limit);
                let text = push(&body, yaw, mu, height, 1.2 * truth, 1.0, 1.0 / 1.2 + 1e-3);
                let (m, recording) = watch(&text);
                let first = recording.events.first().expect("it gives way");
                let kind = if mu < limit { "slip" } else { "state" };
                assert_eq!(first.kind, kind, "{half:?} {height} {mu} {}", first.message);
                // The event is located to 1e-13 of a step.
                assert!((first.time * 1.2 - 1.0).abs() < 1e-9, "{}", first.time * 1.2 - 1.0);
                assert_eq!(m.inconsistent, 0);
            }
        }
    }
}

#[test]
fn tipping_is_a_pendulum_about_the_edge() {
    for (half, yaw) in [([0.05, 0.08, 0.1], 0.0), ([0.1, 0.05, 0.15], 0.7), ([0.02, 0.03, 0.06], -2.0)] {
        let body = Body::new(half, 0.9);
        let [a, _, c] = half;
        let height = 1.6 * c;
        let tips = body.mass * G * a / height;
        let (start, duration) = (1.0 / 1.2, 1.0 / 1.2 + 0.12);
        let text = push(&body, yaw, 2.0, height, 1.2 * tips, 1.0, duration);
        let m = run(&text);
        // I phi'' = F (height cos + a sin) - m g (a cos - c sin), phi the angle about the leading edge.
        let inertia = body.inertia()[1] + body.mass * (a * a + c * c);
        let truth = rk4([0.0, 0.0], duration - start, 4000, |t, [phi, rate]: &[f64; 2]| {
            let (s, cos) = phi.sin_cos();
            let force = 1.2 * tips * (start + t).min(1.0);
            let moment = force * (height * cos + a * s) - body.mass * G * (a * cos - c * s);
            [*rate, moment / inertia]
        });
        // The tilt grows like t^3 from the event; integration at 1e-9.
        assert!(truth[0] > 1e-3, "it moved: {truth:?}");
        let tilt = m.final_base_rpy[1];
        assert!((tilt - truth[0]).abs() < 1e-8, "{tilt} {truth:?}");
        assert_eq!((m.first_slip_s, m.inconsistent), (None, 0));
    }
}

#[test]
fn a_fast_sliding_block_does_not_hop() {
    for (mu, half) in [(0.5, [0.1, 0.1, 0.05]), (1.0, [0.1, 0.1, 0.05]), (0.9, [0.12, 0.08, 0.07])] {
        let body = Body::new(half, 1.0);
        for k in 0..8 {
            let heading = 0.15 + k as f64 * std::f64::consts::TAU / 8.0;
            let (s, c) = heading.sin_cos();
            let speed = 6.0;
            let base = format!("linear_velocity = [{}, {}, 0.0]", speed * c, speed * s);
            let text = format!(
                "duration = {}\nfloor = {{ friction = {mu} }}\n{}{TIGHT}",
                speed / (mu * G) + 0.05,
                body.robot(&base)
            );
            let m = run(&text);
            // No vertex may leave the floor: drift between projections is far below 1e-9.
            assert!(
                m.max_lift_m.unwrap() < 1e-9 && m.max_penetration_m < 1e-9,
                "{:?} {}",
                m.max_lift_m,
                m.max_penetration_m
            );
            assert_eq!((m.first_liftoff_s, m.impacts, m.inconsistent), (None, 0, 0));
            assert!(m.final_base_rpy[0].abs() + m.final_base_rpy[1].abs() < 1e-9);
        }
    }
}
