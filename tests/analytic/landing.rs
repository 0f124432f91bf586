//! Flat landings: instant, loss, and floor friction on a body that lands while moving sideways.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, run, watch};

fn base(body: &Body, height: f64, yaw: f64, velocity: [f64; 3]) -> String {
    let z = body.half[2] + height;
    body.robot(&format!("position = [0.0, 0.0, {z}], rpy = [0.0, 0.0, {yaw}], linear_velocity = {velocity:?}"))
}

#[test]
fn a_dropped_body_lands_in_time_loses_its_height_and_rests() {
    for (body, height, yaw) in
        Body::several().into_iter().zip([0.3, 0.05, 1.0, 0.2]).zip([0.0, 0.7, 2.0, -1.1]).map(|((b, h), y)| (b, h, y))
    {
        let fall = (2.0 * height / G).sqrt();
        let text = format!("duration = {}\n{}{TIGHT}", fall + 0.3, base(&body, height, yaw, [0.0; 3]));
        let (m, recording) = watch(&text);
        let touch = m.first_touchdown_s.expect("it lands");
        // Rounding of positions, 1e-16 m, over the speed of landing; the location itself is good to 1e-13 of a step.
        assert!((touch / fall - 1.0).abs() < 1e-12, "{touch} {fall}");
        assert_eq!((m.impacts, m.inconsistent, m.jams), (1, 0, 0));
        let impact = recording.events.iter().find(|e| e.kind == "impact").expect("it is reported");
        let loss: f64 =
            impact.message.split("lost ").nth(1).and_then(|s| s.split(' ').next()).unwrap().parse().unwrap();
        // The message has seven digits.
        assert!((loss / (body.mass * G * height) - 1.0).abs() < 1e-6, "{loss}");
        // Energy of start and end are known exactly; the loss is accumulated during the run.
        // Integration at 1e-9.
        assert!(m.energy_error_j.abs() < 1e-9 * body.mass * G * height, "{}", m.energy_error_j);
        assert!((m.final_base_position[2] - body.half[2]).abs() < 1e-12, "rests on the floor");
        assert!(m.final_base_velocity.iter().all(|v| v.abs() < 1e-12), "rests");
        assert!((m.final_base_rpy[2] - yaw).abs() < 1e-12 && m.max_penetration_m < 1e-12);
    }
}

#[test]
fn landing_sideways_reduces_the_slip_by_mu_times_the_normal_impulse() {
    let height = 0.1;
    let fall = (2.0 * height / G).sqrt();
    for (body, mu) in Body::several().into_iter().zip([0.3, 0.5, 0.2, 0.4]) {
        for k in 0..5 {
            let (heading, speed) = (0.2 + 1.3 * k as f64, 2.0);
            let (s, c) = heading.sin_cos();
            // Impulse: m v_n from the floor, mu m v_n against the slip. Then Coulomb friction to the stop.
            let after = speed - mu * G * fall;
            assert!(after > 0.0);
            let way = speed * fall + after * after / (2.0 * mu * G);
            let text = format!(
                "duration = {}\nfloor = {{ friction = {mu} }}\n{}{TIGHT}",
                fall + after / (mu * G) + 0.1,
                base(&body, height, 0.4 * k as f64, [speed * c, speed * s, 0.0])
            );
            let m = run(&text);
            let [x, y, _] = m.final_base_position;
            // Integration at relative tolerance 1e-9 over some ten steps.
            assert!(((x * c + y * s) / way - 1.0).abs() < 1e-8, "{} {way}", x * c + y * s);
            assert!((x * s - y * c).abs() < 1e-9, "sideways");
            assert_eq!((m.impacts, m.inconsistent, m.jams), (1, 0, 0));
        }
    }
}

#[test]
fn bounces_reach_the_heights_of_the_restitution_and_end() {
    for (body, e) in Body::several().into_iter().zip([0.5, 0.8, 0.3, 0.6]) {
        let height = 0.2;
        let fall = (2.0 * height / G).sqrt();
        // Approaches slower than this do not bounce.
        let rest = 0.05;
        let mut truth = vec![fall];
        let mut speed: f64 = G * fall;
        while e * speed > rest {
            speed *= e;
            truth.push(truth.last().unwrap() + 2.0 * speed / G);
        }
        // One more hop, which ends too slow to bounce.
        let end = truth.last().unwrap() + 2.0 * e * speed / G;
        let text = format!(
            "duration = {}\n{}
            integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
            contact = {{ restitution = {e}, velocity_tolerance = {rest}, distance_tolerance = 1e-8, acceleration_tolerance = 1e-8 }}",
            end + 0.2,
            base(&body, height, 0.3, [0.0; 3]),
        );
        let (m, recording) = watch(&text);
        let impacts: Vec<f64> = recording.events.iter().filter(|e| e.kind == "impact").map(|e| e.time).collect();
        assert!(impacts.len() >= truth.len() && impacts[truth.len()..].iter().all(|t| (t - end).abs() < 1e-6));
        for (seen, truth) in impacts.iter().zip(&truth) {
            // Flights are parabolas, exact for the integrator; every impact adds its rounding of the speed.
            assert!((seen - truth).abs() < 1e-10, "{seen} {truth}");
        }
        // At rest within the distance tolerance.
        assert!((m.final_base_position[2] - body.half[2]).abs() < 1.1e-8 && m.inconsistent == 0);
        assert!(m.final_base_velocity.iter().all(|v| v.abs() < 1e-12));
    }
}

#[test]
fn fixed_steps_find_a_state_for_every_tilted_landing() {
    // Corners that land in one step stop three of a face at once, and with them the fourth, which
    // was leaving.
    let mut number = 1u64;
    let mut draw = |size: f64| {
        number = number.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        size * ((number >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
    };
    for mu in [0.0, 0.05, 0.3] {
        for _ in 0..20 {
            let (rpy, spin) = ([draw(0.5), draw(0.5), 0.1], [1.0, 2.0, draw(3.0)]);
            let drop = |method: &str| {
                run(&format!(
                    "duration = 0.5
                    robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, 0.2], rpy = {rpy:?}, linear_velocity = [1, 0.3, 0], angular_velocity = {spin:?} }} }}
                    floor = {{ friction = {mu} }}
                    contact = {{ method = \"{method}\" }}
                    integrator = {{ method = \"semi-implicit\", step = 1e-3 }}\n"
                ))
            };
            let (exact, ncp) = (drop("exact"), drop("ncp"));
            assert_eq!((exact.inconsistent, exact.jams), (0, 0), "{mu} {rpy:?} {spin:?}");
            // Of several hundred N s / s at an impact.
            assert!(exact.max_cone_excess < 1e-6, "{mu} {rpy:?} {spin:?}: {}", exact.max_cone_excess);
            if mu == 0.0 {
                // Nothing deflects a frictionless slide, whichever corner lands when.
                for m in [&exact, &ncp] {
                    assert!(
                        (m.final_com_velocity[0] - 1.0).abs() < 1e-12 && (m.final_com_velocity[1] - 0.3).abs() < 1e-12
                    );
                }
            }
        }
    }
}
