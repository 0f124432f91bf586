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
use super::support::{TIGHT, hard_push, run};

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
    // CB-i lands on one edge, of which a vertex almost stops while the other slides on. The normal force
    // of the latter, and with it the power of friction, responds to the direction of the former.
    let m = run("duration = 1.25
        floor.friction = 0.526281982817154
        contact.velocity_tolerance = 0.02
        control.rate = 500
        log.rate = 0
        integrator.method = \"dopri5\"
        robot = { model = \"robots/cbi/cbi.toml\", base = { rpy = [0.2, 0, 0], linear_velocity = [0, 0, -0.6264] } }");
    // The integrator; 1e-5 J with the power of friction as a function of time alone.
    assert!(m.max_energy_error_j < 1e-6, "{}", m.max_energy_error_j);
}

#[test]
fn loads_stay_within_their_cones_where_slow_vertices_are_set_to_rest() {
    // Setting one vertex to rest turns the directions of other slow ones, and the other foot's load.
    let m = run(&hard_push(
        "cbi",
        "",
        "duration = 2.0
        seed = 9
        floor.friction = 0.1517853617873551
        integrator = { method = \"dopri5\", relative_tolerance = 1e-4, absolute_tolerance = 1e-12 }",
    ));
    // Rounding, relative to some 100 N.
    assert!(m.max_cone_excess < 1e-9, "{}", m.max_cone_excess);
}
