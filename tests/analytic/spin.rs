//! A box that spins to rest, and one that slides and spins at once.

use super::body::{Body, G};
use super::planar;
use crate::support::runs::{TIGHT, rk4, run};

fn scenario(body: &Body, mu: f64, velocity: [f64; 2], spin: f64, duration: f64) -> String {
    let base =
        format!("linear_velocity = [{}, {}, 0.0], angular_velocity = [0.0, 0.0, {spin}]", velocity[0], velocity[1]);
    format!("duration = {duration}\nfloor = {{ friction = {mu} }}\n{}{TIGHT}", body.robot(&base))
}

/// Difference of two angles, in -pi..pi.
fn apart(a: f64, b: f64) -> f64 {
    (a - b).sin().atan2((a - b).cos())
}

#[test]
fn a_spinning_body_comes_to_rest_by_friction_at_its_corners() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.3, 0.8, 0.2]) {
        for spin in [3.0_f64, -8.0] {
            let decay = mu * body.mass * G * body.radius() / body.inertia()[2];
            let time = spin.abs() / decay;
            let m = run(&scenario(&body, mu, [0.0; 2], spin, time + 0.1));
            let angle = spin * time / 2.0;
            // Integration at relative tolerance 1e-9.
            assert!(apart(m.final_base_rpy[2], angle).abs() < 1e-8 * angle.abs().max(1.0), "{:?}", m.final_base_rpy);
            assert!((m.first_stick_s.expect("it stops") / time - 1.0).abs() < 1e-8);
            let [x, y, z] = m.final_base_position;
            assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && (z - body.half[2]).abs() < 1e-12, "{x} {y} {z}");
            assert_eq!(m.inconsistent, 0);
        }
    }
}

#[test]
fn sliding_with_spin_follows_an_independent_quadrature() {
    for (body, mu) in Body::several().into_iter().zip([0.3, 0.4, 0.25, 0.15]) {
        for (vx, vy, turn) in [(1.0, 0.2, 1.0_f64), (-0.5, 0.8, -0.5), (0.3, 0.3, 2.0)] {
            let spin = turn / body.radius();
            // At most v / (mu g) and w I / (mu m g r) are needed to stop; half the smaller one is
            // well before.
            let decay = mu * body.mass * G * body.radius() / body.inertia()[2];
            let duration = 0.5 * (f64::hypot(vx, vy) / (mu * G)).min(spin.abs() / decay);
            let truth = rk4([0.0, 0.0, 0.0, vx, vy, spin], duration, 20_000, |_, s| planar::derivative(&body, mu, s));
            let m = run(&scenario(&body, mu, [vx, vy], spin, duration));
            let [x, y, z] = m.final_base_position;
            // Integration at relative tolerance 1e-9 (absolute 1e-11) over a few hundred steps.
            // Where a corner passes close to rest, its direction rotates fast and the error of a
            // step is at its limit.
            assert!((x - truth[0]).hypot(y - truth[1]) < 1e-8, "{x} {y} {truth:?}");
            assert!(apart(m.final_base_rpy[2], truth[2]).abs() < 1e-7, "{:?} {truth:?}", m.final_base_rpy);
            assert!((m.final_base_velocity[0] - truth[3]).hypot(m.final_base_velocity[1] - truth[4]) < 1e-7);
            assert!((z - body.half[2]).abs() < 1e-12 && m.inconsistent == 0);
        }
    }
}

#[test]
fn sliding_with_spin_stops_at_the_position_of_the_quadrature() {
    let body = Body::new([0.1, 0.1, 0.02], 1.0);
    let mu = 0.3;
    for (vx, vy, spin) in [(1.0, 0.2, 6.0_f64), (0.4, -0.7, -3.0)] {
        let mut state = [0.0, 0.0, 0.0, vx, vy, spin];
        let mut time = 0.0;
        // Pieces of decreasing length, to the last 1e-7 of the speed.
        while f64::hypot(state[3], state[4]) + state[5].abs() * body.radius() > 1e-7 {
            let piece = 0.1 * (f64::hypot(state[3], state[4]) + state[5].abs() * body.radius()) / (mu * G);
            state = rk4(state, piece, 400, |_, s| planar::derivative(&body, mu, s));
            time += piece;
        }
        let m = run(&scenario(&body, mu, [vx, vy], spin, time + 0.2));
        let [x, y, _] = m.final_base_position;
        // Integration errors of the whole slide.
        assert!((x - state[0]).hypot(y - state[1]) < 1e-7, "{x} {y} {state:?}");
        assert!(apart(m.final_base_rpy[2], state[2]).abs() < 1e-6, "{:?} {state:?}", m.final_base_rpy);
        // From 1e-7 m/s, coming to rest takes at most 1e-7 / (mu g r / radius of gyration), some
        // 1e-7 s.
        assert!((m.first_stick_s.expect("it stops") - time).abs() < 1e-6);
        assert_eq!((m.inconsistent, m.jams), (0, 0));
    }
}
