//! Slow sliding, in which friction turns faster than explicit steps resolve.
//!
//! A block on a slope of the friction angle (tan theta = mu) that slides across it at v0 turns
//! downhill. Gravity along the slope and friction are equal, so that speed s and angle phi to the
//! downhill direction obey
//!
//! ```text
//! s' = g sin(theta) (cos phi - 1),   s phi' = -g sin(theta) sin phi   =>   s (1 + cos phi) = v0
//! ```
//!
//! After a time of some v0 / (g sin theta) it creeps downhill at v0 / 2. Friction then answers a
//! deviation of the direction at the rate g sin(theta) / s.

use super::body::G;
use crate::support::runs::{TIGHT, hard_push, run};

const ANGLE: f64 = 0.3;

fn creeping(speed: f64, duration: f64) -> stiction::sim::Metrics {
    sliding([0.0, speed, 0.0], 1.0, duration, TIGHT)
}

/// The block with an initial velocity, and friction relative to the critical one.
fn sliding(velocity: [f64; 3], friction: f64, duration: f64, tolerances: &str) -> stiction::sim::Metrics {
    run(&format!(
        "duration = {duration}
        floor = {{ friction = {}, rpy = [0, {ANGLE}, 0] }}
        robot = {{ model = \"robots/block/block.toml\", base = {{ rpy = [0, {ANGLE}, 0], linear_velocity = {velocity:?} }} }}
        log = {{ rate = 0 }}
        {tolerances}",
        friction * ANGLE.tan()
    ))
}

#[test]
fn a_block_that_slides_across_a_critical_slope_creeps_downhill_at_half_its_speed() {
    for speed in [1e-2, 1e-4, 1e-5] {
        let m = creeping(speed, 1.0);
        let v = m.final_base_velocity;
        let downhill = v[0].hypot(v[2]);
        // Relative tolerance of the integrator, 1e-9 a step, over the steps of the turn; with a
        // speed of 1e-5 m/s its absolute tolerance of 1e-11.
        assert!((downhill / speed - 0.5).abs() < 1e-5, "{speed}: {downhill}");
        assert!(v[1].abs() < 1e-6 * speed, "{speed}: {v:?}");
        assert_eq!(m.inconsistent, 0);
    }
}

#[test]
fn steps_do_not_shrink_with_the_speed() {
    let (speed, duration) = (1e-5, 1.0);
    let m = creeping(speed, duration);
    // Explicit steps are stable up to about 3.3 over the rate of friction.
    let explicit = duration * G * ANGLE.sin() / (0.5 * speed) / 3.3;
    assert!((m.steps as f64) < 0.01 * explicit, "{} steps, explicit {explicit:.0}", m.steps);
}

#[test]
fn a_slide_that_stops_turns_back_at_the_right_instant() {
    // Straight uphill but for a millionth, on a slope a little steeper than the friction angle. The
    // block stops after v / (g sin 1.99) and slides back with g sin 0.01. Its sideways speed, some
    // v (1e-6)^(3/2) by then, must not deflect it.
    let (duration, gravity) = (0.2, G * ANGLE.sin());
    for speed in [0.01, 0.02, 0.0546, 0.1, 0.2, 0.3] {
        let velocity = [-speed * ANGLE.cos(), 1e-6 * speed, speed * ANGLE.sin()];
        let m =
            sliding(velocity, 0.99, duration, "integrator = { relative_tolerance = 1e-7, absolute_tolerance = 1e-9 }");
        let expected = 0.01 * gravity * (duration - speed / (1.99 * gravity));
        let v = m.final_base_velocity;
        // The integrator, relative to the first speed.
        assert!((v[0].hypot(v[2]) - expected).abs() < 1e-7 * speed, "{speed}: {v:?} {expected}");
        assert!(v[1].abs() < 1e-9, "{speed}: {v:?}");
        assert!(m.steps < 500, "{m:?}");
    }
}

#[test]
fn energy_balances_where_slow_vertices_turn() {
    // CB-i tips down a slope. Normal forces, and with them the power of friction, respond to the
    // directions of vertices that slide slowly.
    let m = run(&hard_push(
        "cbi",
        "rpy = [0, \"12 deg\", 0]",
        "duration = 1.87
        seed = 19
        floor = { friction = 0.7884208775345365, rpy = [0, \"12 deg\", 0] }
        integrator.method = \"dopri5\"",
    ));
    // The integrator: 5e-9 J seen. 3e-7 J with the power of friction as a function of time alone.
    assert!(m.max_energy_error_j < 5e-8, "{}", m.max_energy_error_j);
}

#[test]
fn loads_stay_within_their_cones_where_slow_vertices_are_set_to_rest() {
    // Setting a vertex of HOAP-2 to rest, or ending a slip below the rest speed, turns the directions of
    // other slow vertices, and with them loads. Without another choice of states a load exceeds its cone
    // by 0.3 N, and by 0.05 N.
    for friction in [0.37365549557732924, 0.33580893978011356] {
        let settings =
            format!("duration = 1.03\nseed = 19\nfloor.friction = {friction}\nintegrator.method = \"dopri5\"");
        let m = run(&hard_push("hoap2", "", &settings));
        // Rounding, relative to some 100 N.
        assert!(m.max_cone_excess < 1e-9, "{friction} {}", m.max_cone_excess);
    }
}
