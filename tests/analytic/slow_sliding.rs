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
use super::support::{TIGHT, run};

const ANGLE: f64 = 0.3;

fn creeping(speed: f64, duration: f64) -> stiction::sim::Metrics {
    run(&format!(
        "duration = {duration}
        floor = {{ friction = {}, rpy = [0, {ANGLE}, 0] }}
        robot = {{ model = \"robots/block/block.toml\", base = {{ rpy = [0, {ANGLE}, 0], linear_velocity = [0, {speed}, 0] }} }}
        log = {{ rate = 0 }}
        {TIGHT}",
        ANGLE.tan()
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
