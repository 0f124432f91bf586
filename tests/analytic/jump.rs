//! Load jumps: the contact state changes at the instant of the jump, not at the end of the
//! following step.

use super::body::G;
use crate::support::runs::{TIGHT, run, watch};

#[test]
fn a_sudden_push_slips_the_block_at_once() {
    for (start, duration, mu, force) in [(0.2, 0.5, 0.2, 3.0), (0.1234567, 0.3, 0.05, 2.0), (0.0, 0.4, 0.4, 5.0)] {
        let m = run(&format!(
            "duration = 3.0
            floor = {{ friction = {mu} }}
            robot = {{ model = \"robots/block/block.toml\" }}
            {TIGHT}
            [[force]]
            type = \"push\"
            link = \"block\"
            point = [0, 0, -0.05]
            force = [{force}, 0, 0]
            start = {start}
            duration = {duration}\n"
        ));
        let (a, b) = (force - mu * G, mu * G);
        let way = 0.5 * a * duration * duration * (1.0 + a / b);
        // Parabolas, exact for the integrator; the location of the stop.
        assert!((m.final_base_position[0] / way - 1.0).abs() < 1e-9, "{}", m.final_base_position[0] / way - 1.0);
        let stop = start + duration * (1.0 + a / b);
        assert!((m.first_stick_s.expect("it stops") / stop - 1.0).abs() < 1e-9);
        if start > 0.0 {
            assert_eq!(m.first_slip_s, Some(start));
        }
        assert_eq!((m.inconsistent, m.impacts), (0, 0));
    }
}

#[test]
fn a_lift_that_ends_drops_the_block_at_once() {
    let (m, recording) = watch(&format!(
        "duration = 0.6
        robot = {{ model = \"robots/block/block.toml\" }}
        {TIGHT}
        [[force]]
        type = \"push\"
        link = \"block\"
        force = [0, 0, 12]
        start = 0.1
        duration = 0.2\n"
    ));
    // Upwards with 12 N - m g for 0.2 s, then free flight.
    let (a, t) = (12.0 - G, 0.2);
    let (h, v) = (0.5 * a * t * t, a * t);
    let lands = 0.3 + (v + (v * v + 2.0 * G * h).sqrt()) / G;
    assert_eq!(m.first_liftoff_s, Some(0.1));
    assert!((m.first_touchdown_s.expect("it lands") - lands).abs() < 1e-10, "{:?} {lands}", m.first_touchdown_s);
    assert_eq!((recording.events[0].kind.as_str(), recording.events[0].time, m.inconsistent), ("liftoff", 0.1, 0));
    // In equilibrium to rounding while pushed along the floor's normal by less than its weight.
    assert!((m.final_base_position[2] - 0.05).abs() < 1e-10);
}
