//! A block on a slope holds below the friction angle and slides with `g (sin - mu cos)` above it, whatever the heading.

use super::body::{Body, G};
use super::support::{TIGHT, run};
use nalgebra::{Unit, UnitQuaternion, Vector3};

struct Slope {
    downhill: Vector3<f64>,
    rpy: [f64; 3],
}

/// A plane that descends by `angle` towards `heading`.
fn slope(angle: f64, heading: f64) -> Slope {
    let (s, c) = heading.sin_cos();
    let rotation = UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::new(-s, c, 0.0)), angle);
    let (roll, pitch, yaw) = rotation.euler_angles();
    Slope { downhill: rotation * Vector3::new(c, s, 0.0), rpy: [roll, pitch, yaw] }
}

fn scenario(body: &Body, slope: &Slope, friction: &str, duration: f64) -> String {
    format!(
        "duration = {duration}\nfloor = {{ friction = {friction}, rpy = {:?} }}\n{}{TIGHT}",
        slope.rpy,
        body.robot(&format!("rpy = {:?}", slope.rpy))
    )
}

fn moved(body: &Body, angle: f64, position: [f64; 3]) -> Vector3<f64> {
    Vector3::from(position) - Vector3::new(0.0, 0.0, body.half[2] / angle.cos())
}

#[test]
fn holds_below_the_friction_angle_for_every_heading() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.1, 0.6, 0.3]) {
        for k in 0..12 {
            // 99.9 % of the friction angle, with kinetic friction that would never hold.
            let angle = 0.999 * f64::atan(mu);
            let slope = slope(angle, 0.05 + k as f64 * std::f64::consts::TAU / 12.0);
            let friction = format!("{{ static = {mu}, kinetic = {} }}", 0.5 * mu);
            let m = run(&scenario(&body, &slope, &friction, 1.0));
            // A static sole keeps its place to rounding.
            assert!(moved(&body, angle, m.final_base_position).norm() < 1e-12, "{:?}", m.final_base_position);
            assert_eq!((m.first_slip_s, m.inconsistent, m.state_changes), (None, 0, 0));
        }
    }
}

#[test]
fn slides_above_the_friction_angle_for_every_heading() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.1, 0.6, 0.3]) {
        for k in 0..12 {
            for (beyond, duration) in [(1.001, 1.0), (1.2, 0.5)] {
                let angle = beyond * f64::atan(mu);
                let slope = slope(angle, 0.05 + k as f64 * std::f64::consts::TAU / 12.0);
                let m = run(&scenario(&body, &slope, &mu.to_string(), duration));
                let way = 0.5 * G * (angle.sin() - mu * angle.cos()) * duration * duration;
                let moved = moved(&body, angle, m.final_base_position);
                // A parabola, exact for the integrator: what is left is rounding of forces, 1e-15 of g t^2 / 2, times the
                // cancellation between weight and friction.
                assert!((moved - slope.downhill * way).norm() < 1e-12, "{moved} {way} {}", slope.downhill);
                assert_eq!(m.inconsistent, 0);
            }
        }
    }
}
